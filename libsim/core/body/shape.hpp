// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "libsim/core/export.hpp"

namespace cas::sim {

/// A surface of triangles.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;                ///< m, in the shape's own frame
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into `vertices`
};

/// A box about the origin of its pose.
struct Box {
  Eigen::Vector3d size_m;  ///< edge lengths
};
/// A sphere about the origin of its pose.
struct Sphere {
  double radius_m;  ///< m
};
/// A cylinder about the origin of its pose.
struct Cylinder {
  double radius_m;
  double length_m;  ///< along z
};
/// Infinite: z = 0 of its pose, solid below.
struct Plane {};
/// Triangles that several shapes may share.
struct Mesh {
  std::shared_ptr<const TriangleMesh> triangles;
};
/// Geometry of a shape.
using Geometry = std::variant<Box, Sphere, Cylinder, Plane, Mesh>;

/// Contact properties of a shape; a contact takes the smaller friction of the two.
struct Surface {
  /// Coulomb coefficient; 1 is the default of the SDF specification.
  double friction = 1.0;
  /// Spring and damper of one contact, N/m and N s/m; none: the default, scaled by the mass.
  std::optional<double> stiffness_n_m{};
  std::optional<double> damping_n_s_m{};

  bool operator==(const Surface&) const = default;
};

/// A collision shape: in W for the world, about the centre of gravity in B for a vehicle.
struct Shape {
  std::string name;
  Geometry geometry;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in the parent frame, m
  Surface surface;
};

/// Radius of the sphere about the origin of `pose`'s parent frame that holds the shape, m;
/// infinite for a plane.
CAS_SIM_EXPORT double bounding_radius(const Shape& shape);

/// Smallest z over the shape when the parent frame is rotated by `R`, m; minus infinity for a
/// plane.
CAS_SIM_EXPORT double lowest_point(const Shape& shape, const Eigen::Matrix3d& R);

}  // namespace cas::sim
