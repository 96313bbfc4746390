// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "libsim/core/body/shape.hpp"
#include "libsim/core/load/sdf_headers.hpp"

namespace cas::sim {

/// Smallest and largest extent of a shape of a world, m, and its farthest place.
inline constexpr double kSmallest_m = 1e-9;
inline constexpr double kLargest_m = 1e8;

/// False for what is no number, too.
constexpr bool is_within(double value, double low, double high) {
  return value >= low && value <= high;
}

Eigen::Vector3d to_eigen(const ignition::math::Vector3d& v);
Eigen::Isometry3d to_eigen(const ignition::math::Pose3d& pose);

/// Takes a box, sphere, cylinder or plane, which turns the pose of the shape.
/// @param who  "FILE:LINE: collision 'NAME'", for the error
/// @return false for any other geometry
/// @throws base::ConfigError for a size that no body has
bool take_sdf_primitive(const sdf::Geometry& geometry, const std::string& who, Shape& shape);

/// Friction, stiffness and damping.
/// @param name  of the shape
/// @param warnings  takes a sentence for a damping of zero, which is left out
/// @throws base::ConfigError for a negative one
Surface sdf_surface(const sdf::Collision& collision, const std::string& name,
                    std::vector<std::string>& warnings);

/// Whether a vehicle, which has all 16 bits, feels it.
bool is_solid(const sdf::Collision& collision);

}  // namespace cas::sim
