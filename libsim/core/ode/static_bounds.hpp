// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "libsim/core/ode/geometry.hpp"

namespace cas::sim {

/// Where the static world is, coarsely: its planes, and boxes along the axes of W around everything
/// else. Says cheaply, before any collision is looked for, that nothing is near. All in W, m.
class StaticBounds {
 public:
  /// @param geom  the shape's geom, in its place
  void add(const Shape& shape, dGeomID geom);

  /// Whether a sphere may touch anything.
  bool within(const Eigen::Vector3d& p_W, double radius) const;
  /// Whether a disc reaches below a plane.
  bool plane_cuts(const Eigen::Vector3d& centre_W, const Eigen::Vector3d& axis_W,
                  double radius) const;
  /// Whether a sphere may touch anything but planes.
  bool box_within(const Eigen::Vector3d& p_W, double radius) const;
  /// Height of a point over the nearest plane below it; infinite over none.
  double height_above_planes(const Eigen::Vector3d& p_W) const;
  /// Whether a box begins below the point.
  bool box_below(const Eigen::Vector3d& p_W) const;
  /// z of the lowest box; infinite without boxes.
  double lowest_of_boxes() const { return all_boxes_.low.z(); }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  struct PlaneBounds {
    Eigen::Vector3d n;
    double d;
  };
  struct BoxBounds {
    Eigen::Vector3d low;
    Eigen::Vector3d high;

    bool reached_by(const Eigen::Vector3d& p_W, double radius) const;
    bool is_below(const Eigen::Vector3d& p_W) const;
  };

  std::vector<PlaneBounds> planes_;
  std::vector<BoxBounds> boxes_;
  BoxBounds all_boxes_{Eigen::Vector3d::Constant(kInfinity), Eigen::Vector3d::Constant(-kInfinity)};
};

}  // namespace cas::sim
