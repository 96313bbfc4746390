// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/world_loader.hpp"

#include <dlfcn.h>

#include "base/earth/geodesy.hpp"
#include "base/error.hpp"
#include "libsim/core/load/sdf_world.hpp"
#include "libsim/core/terrain/terrain.hpp"

namespace cas::sim {

namespace {

namespace fs = std::filesystem;

/// The SDF reader beside this library, opened when the first SDF file is read.
decltype(&cas_load_sdf_world) open_sdf_reader() {
  Dl_info self{};
  // In a statically linked program the name has no folder; dlopen then searches its path.
  const auto* const inside = reinterpret_cast<const void*>(&open_sdf_reader);
  const fs::path folder =
      dladdr(inside, &self) != 0 ? fs::path(self.dli_fname).parent_path() : fs::path();
  const fs::path file = folder / CAS_SIM_SDF_FILE;
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    throw base::ConfigError("SDF files cannot be read: " + std::string(dlerror()));
  }
  void* const entry = dlsym(library, kLoadSdfWorld);
  if (entry == nullptr) {
    throw base::ConfigError("SDF files cannot be read: " + file.string() +
                            " is of another version of CAS");
  }
  return reinterpret_cast<decltype(&cas_load_sdf_world)>(entry);
}

}  // namespace

WorldModel load_sdf_world(const fs::path& file, const std::vector<fs::path>& model_path,
                          Missing missing) {
  return load_world({.sdf = file, .model_path = model_path, .missing = missing});
}

base::Geodetic home_of(const SimConfig& config, const WorldModel& world) {
  if (config.home) return *config.home;
  if (world.home) return *world.home;
  throw base::ConfigError(config.world.sdf->string() +
                          ": has no <spherical_coordinates>, and the configuration no 'home'");
}

WorldModel load_world(const SimConfig& config) {
  WorldModel model = load_world(config.world);
  const base::Geodetic home = home_of(config, model);
  model.atmosphere = base::air_of(config.weather, model.atmosphere, home.alt_m);
  if (config.terrain) {
    model.terrain = std::make_shared<const Terrain>(*config.terrain, base::LocalProjection(home));
  }
  return model;
}

WorldModel load_world(const WorldConfig& config) {
  if (config.sdf) {
    static const auto read = open_sdf_reader();
    WorldModel model;
    read(config, model);
    return model;
  }
  WorldModel model;
  model.gravity_W = {0, 0, -config.gravity_m_s2};
  if (config.ground) {
    model.statics.push_back({.name = "ground",
                             .geometry = Plane{},
                             .pose = Eigen::Isometry3d::Identity(),
                             .surface = {}});
  }
  return model;
}

}  // namespace cas::sim
