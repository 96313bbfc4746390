// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/rays/ray_scene.hpp"

#include <dlfcn.h>

namespace cas::sim {

namespace fs = std::filesystem;

fs::path ray_library() {
  Dl_info self{};
  // In a statically linked program the name has no folder; dlopen then searches its path.
  const auto* const inside = reinterpret_cast<const void*>(&ray_library);
  const fs::path folder =
      dladdr(inside, &self) != 0 ? fs::path(self.dli_fname).parent_path() : fs::path();
  return folder / CAS_SIM_RAYS_FILE;
}

namespace {

/// nullptr: the library is not there.
decltype(&cas_make_ray_scene) open_ray_library() {
  void* const library = dlopen(ray_library().c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return nullptr;
  return reinterpret_cast<decltype(&cas_make_ray_scene)>(dlsym(library, kMakeRayScene));
}

}  // namespace

std::unique_ptr<RayScene> make_ray_scene(std::span<const Shape> shapes) {
  static const auto make = open_ray_library();
  std::unique_ptr<RayScene> scene;
  if (make != nullptr) make(shapes, scene);
  return scene;
}

}  // namespace cas::sim
