// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/body/floor.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace cas::sim {

namespace {

constexpr double kSteepest = 1e-3;  // z of the normal of a plane that can carry anything

}  // namespace

Floor::Floor(std::span<const Shape> statics) {
  for (const Shape& shape : statics) {
    if (!std::holds_alternative<Plane>(shape.geometry)) {
      lowest_ = std::min(lowest_, lowest_point(shape, Eigen::Matrix3d::Identity()));
      continue;
    }
    const Eigen::Vector3d n = shape.pose.linear().col(2);
    if (n.z() > kSteepest) planes_.push_back({n, n.dot(shape.pose.translation())});
  }
}

bool Floor::is_above(const Eigen::Vector3d& p_W, double radius) const {
  if (planes_.empty() && std::isinf(lowest_)) return false;
  const double reach = radius + kMargin_m;
  return p_W.z() < lowest_ - reach &&
         std::all_of(planes_.begin(), planes_.end(),
                     [&](const Ground& plane) { return plane.n.dot(p_W) - plane.d < -reach; });
}

}  // namespace cas::sim
