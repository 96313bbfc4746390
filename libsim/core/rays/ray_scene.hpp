// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "libsim/api/world.hpp"
#include "libsim/core/body/shape.hpp"
#include "libsim/core/export.hpp"

namespace cas::sim {

/// Shapes that do not move against each other, made ready for many rays. All in the frame of their
/// poses' parent: W for the static world, B for a vehicle.
class RayScene {
 public:
  virtual ~RayScene() = default;
  /// The first surface along a ray. Surfaces have two sides: a ray from inside a shape meets its
  /// far side.
  /// @param direction  unit
  /// @return nullopt: none within the range
  virtual std::optional<RayHit> cast(const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction, double range_m) const = 0;
};

/// The library with Embree, beside this one: opened for the first scene. It need not be there.
CAS_SIM_EXPORT std::filesystem::path ray_library();

/// Makes a scene of the shapes that ContactSolver takes, by Embree.
/// @return nullptr: CAS was built without Embree, or its library is not installed
/// @throws base::ConfigError when Embree cannot take the shapes
CAS_SIM_EXPORT std::unique_ptr<RayScene> make_ray_scene(std::span<const Shape> shapes);

/// Entry point of libcas_sim_rays.so: fills `scene` from the shapes. Embree has a library of its
/// own because it is large, and most flights cast no more than a few rays.
/// @throws base::ConfigError
extern "C" CAS_SIM_EXPORT void cas_make_ray_scene(const std::span<const Shape>& shapes,
                                                  std::unique_ptr<RayScene>& scene);

/// Symbol of cas_make_ray_scene() in libcas_sim_rays.so.
inline constexpr const char* kMakeRayScene = "cas_make_ray_scene";

}  // namespace cas::sim
