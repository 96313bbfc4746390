// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/static_bounds.hpp"

#include <algorithm>
#include <variant>

namespace cas::sim {

void StaticBounds::add(const Shape& shape, dGeomID geom) {
  if (std::holds_alternative<Plane>(shape.geometry)) {
    const Eigen::Vector3d n = shape.pose.linear().col(2);
    planes_.push_back({n, n.dot(shape.pose.translation())});
    return;
  }
  dReal aabb[6];
  dGeomGetAABB(geom, aabb);
  boxes_.push_back({{aabb[0], aabb[2], aabb[4]}, {aabb[1], aabb[3], aabb[5]}});
  all_boxes_.low = all_boxes_.low.cwiseMin(boxes_.back().low);
  all_boxes_.high = all_boxes_.high.cwiseMax(boxes_.back().high);
}

bool StaticBounds::within(const Eigen::Vector3d& p_W, double radius) const {
  for (const PlaneBounds& plane : planes_) {
    if (plane.n.dot(p_W) - plane.d < radius) return true;
  }
  return box_within(p_W, radius);
}

bool StaticBounds::plane_cuts(const Eigen::Vector3d& centre_W, const Eigen::Vector3d& axis_W,
                              double radius) const {
  return std::any_of(planes_.begin(), planes_.end(), [&](const PlaneBounds& plane) {
    const double reach = radius * plane.n.cross(axis_W).norm();
    return plane.n.dot(centre_W) - plane.d < reach;
  });
}

bool StaticBounds::box_within(const Eigen::Vector3d& p_W, double radius) const {
  if (boxes_.empty() || !all_boxes_.reached_by(p_W, radius)) return false;
  return std::any_of(boxes_.begin(), boxes_.end(),
                     [&](const BoxBounds& box) { return box.reached_by(p_W, radius); });
}

double StaticBounds::height_above_planes(const Eigen::Vector3d& p_W) const {
  double height = kInfinity;
  for (const PlaneBounds& plane : planes_) {
    if (plane.n.z() > 0) height = std::min(height, (plane.n.dot(p_W) - plane.d) / plane.n.z());
  }
  return height;
}

bool StaticBounds::box_below(const Eigen::Vector3d& p_W) const {
  if (boxes_.empty() || !all_boxes_.is_below(p_W)) return false;
  return std::any_of(boxes_.begin(), boxes_.end(),
                     [&](const BoxBounds& box) { return box.is_below(p_W); });
}

bool StaticBounds::BoxBounds::reached_by(const Eigen::Vector3d& p_W, double radius) const {
  const Eigen::Vector3d gap = (low - p_W).cwiseMax(p_W - high).cwiseMax(0.0);
  return gap.squaredNorm() <= radius * radius;
}

bool StaticBounds::BoxBounds::is_below(const Eigen::Vector3d& p_W) const {
  return p_W.x() >= low.x() && p_W.x() <= high.x() && p_W.y() >= low.y() && p_W.y() <= high.y() &&
         p_W.z() >= low.z();
}

}  // namespace cas::sim
