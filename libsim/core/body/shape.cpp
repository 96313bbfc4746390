// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/body/shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cas::sim {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Distance from the shape's own origin to its surface, farthest along -d (unit, shape's frame).
struct Depth {
  Eigen::Vector3d d;
  double operator()(const Box& box) const { return 0.5 * d.cwiseAbs().dot(box.size_m); }
  double operator()(const Sphere& sphere) const { return sphere.radius_m; }
  double operator()(const Cylinder& c) const {
    return c.radius_m * std::hypot(d.x(), d.y()) + 0.5 * c.length_m * std::abs(d.z());
  }
  double operator()(const Plane&) const { return kInfinity; }
  double operator()(const Mesh& mesh) const {
    double depth = -kInfinity;
    for (const Eigen::Vector3d& v : mesh.triangles->vertices) depth = std::max(depth, -v.dot(d));
    return depth;
  }
};

struct Radius {
  const Eigen::Isometry3d& pose;
  double operator()(const Box& box) const {
    return pose.translation().norm() + 0.5 * box.size_m.norm();
  }
  double operator()(const Sphere& sphere) const {
    return pose.translation().norm() + sphere.radius_m;
  }
  double operator()(const Cylinder& c) const {
    return pose.translation().norm() + std::hypot(c.radius_m, 0.5 * c.length_m);
  }
  double operator()(const Plane&) const { return kInfinity; }
  double operator()(const Mesh& mesh) const {
    double radius = 0;
    for (const Eigen::Vector3d& v : mesh.triangles->vertices) {
      radius = std::max(radius, (pose * v).norm());
    }
    return radius;
  }
};

}  // namespace

double bounding_radius(const Shape& shape) {
  return std::visit(Radius{shape.pose}, shape.geometry);
}

double lowest_point(const Shape& shape, const Eigen::Matrix3d& R) {
  const Eigen::Vector3d up = R.transpose() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up_in_shape = shape.pose.linear().transpose() * up;
  return up.dot(shape.pose.translation()) - std::visit(Depth{up_in_shape}, shape.geometry);
}

}  // namespace cas::sim
