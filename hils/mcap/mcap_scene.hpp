// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "base/config/vehicle.hpp"
#include "base/time/clock.hpp"
#include "libsim/core/body/shape.hpp"

namespace cas::hils {

/// {"sec", "nsec"}: a moment as Foxglove has it.
nlohmann::ordered_json mcap_time(base::SimTime time);
/// {"x", "y", "z"}, {"x", "y", "z", "w"} of single precision.
nlohmann::ordered_json mcap_vector(const Eigen::Vector3d& vector);
nlohmann::ordered_json mcap_quaternion(const Eigen::Quaterniond& q);

/// Red, green, blue, opacity, 0 to 1.
struct McapColor {
  double r, g, b, a;
};

/// A foxglove.SceneEntity of boxes, spheres, cylinders and triangles in a frame, from the begin on.
/// Planes, which have no end, are left out.
nlohmann::ordered_json mcap_entity(const std::string& id, const std::string& frame,
                                   std::span<const sim::Shape> shapes, const McapColor& color);
/// Discs of the rotors, and an arm to each.
nlohmann::ordered_json mcap_rotors(const std::string& id, const std::string& frame,
                                   std::span<const base::Rotor> rotors);
/// A line from point to point.
nlohmann::ordered_json mcap_line(const std::string& id, const std::string& frame,
                                 std::span<const Eigen::Vector3d> points, const McapColor& color);

}  // namespace cas::hils
