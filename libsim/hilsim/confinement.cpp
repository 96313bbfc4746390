// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/confinement.hpp"

#include <cstdlib>
#include <set>
#include <sstream>
#include <string>
#include <variant>

#include "base/config/config.hpp"
#include "base/config/install_paths.hpp"
#include "libsim/core/load/model_loader.hpp"
#include "libsim/core/rays/ray_scene.hpp"

namespace cas::sim {

namespace {

using Places = std::vector<std::filesystem::path>;

/// Libraries, their settings, devices, and what the C library looks up at run time.
constexpr const char* kSystem[] = {"/usr", "/lib", "/lib64", "/etc",
                                   "/opt", "/dev", "/proc",  "/sys"};

void add(Places& places, const Places& more) {
  places.insert(places.end(), more.begin(), more.end());
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.parent_path();
  return folder.empty() ? "." : folder;
}

void add_library_path(Places& places) {
  const char* const value = std::getenv("LD_LIBRARY_PATH");
  std::istringstream folders(value == nullptr ? "" : value);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (!folder.empty()) places.emplace_back(folder);
  }
}

/// Each value below the node that is the name of a file.
void add_named(Places& places, const base::ConfigNode& node) {
  if (node.is_map()) {
    for (const auto& [key, child] : node.entries()) add_named(places, child);
  } else if (node.is_list()) {
    for (const base::ConfigNode& child : node.items()) add_named(places, child);
  } else if (node.is_scalar()) {
    const std::filesystem::path named = node.resolve(node.as<std::string>());
    std::error_code error;
    if (std::filesystem::is_regular_file(named, error)) places.push_back(named);
  }
}

/// The folders of configuration files, and the files that they name. They are read anew: keys that
/// are read here would count as used.
void add_configs(Places& places, const std::set<std::filesystem::path>& files) {
  for (const std::filesystem::path& file : files) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) continue;  // of defaults: "<none>"
    places.push_back(folder_of(file));
    add_named(places, base::ConfigNode::load(file));
  }
}

}  // namespace

Places readable_places(const SimRunner& runner, const std::filesystem::path& file,
                       const Places& plugin_dirs) {
  Places places(std::begin(kSystem), std::end(kSystem));
  add(places, base::config_dirs());
  add(places, base::plugin_dirs());
  add(places, plugin_dirs);
  add_library_path(places);
  places.push_back(folder_of(ray_library()));
  if (const auto& terrain = runner.config().terrain) add(places, terrain->files);
  std::set<std::filesystem::path> configs{file};
  for (const VehicleConfig& vehicle : runner.config().vehicles) {
    places.push_back(folder_of(vehicle.vehicle.urdf));
    configs.insert(vehicle.vehicle.sensors.file());
    for (const PluginConfig& plugin : vehicle.plugins) configs.insert(plugin.params.file());
  }
  add_configs(places, configs);
  for (const VehicleModel& model : runner.vehicle_models()) {
    for (const Visual& visual : model.visuals) {
      if (const auto* mesh = std::get_if<MeshFile>(&visual.form)) places.push_back(mesh->path);
    }
  }
  return places;
}

Places serial_places(const SimConfig& config) {
  Places places;
  for (const VehicleConfig& vehicle : config.vehicles) {
    for (const PluginConfig& plugin : vehicle.plugins) {
      if (plugin.plugin != "external_ahrs" && plugin.plugin != "ubx") continue;
      if (plugin.params.has("device")) places.emplace_back("/dev");
      const auto pty = plugin.params.find("pty");
      if (!pty) continue;
      places.emplace_back("/dev/ptmx");
      places.push_back(folder_of(pty->as<std::string>()));
    }
  }
  return places;
}

}  // namespace cas::sim
