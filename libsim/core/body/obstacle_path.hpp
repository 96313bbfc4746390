// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "libsim/api/world.hpp"
#include "libsim/core/body/shape.hpp"
#include "libsim/core/export.hpp"

namespace cas::sim {

/// Where a moving obstacle is at a time.
struct Waypoint {
  double time_s;
  Eigen::Isometry3d pose;  ///< in W
};

/// The way of an obstacle that nothing stops: straight from place to place at even speed, turning
/// evenly on the way.
class CAS_SIM_EXPORT ObstaclePath {
 public:
  /// @param waypoints  at least one, times rising
  /// @param loop  begins again at the first one's time when the last one's has passed; else it
  /// stays at the last one
  /// @param delay_s  time at the first place before it moves
  ObstaclePath(std::vector<Waypoint> waypoints, bool loop, double delay_s);

  /// Pose, velocity and rates at a time of the simulation; no accelerations.
  BodyState at(double time_s) const;

 private:
  std::vector<Waypoint> waypoints_;
  bool loop_;
  double delay_s_;
};

/// An obstacle on its way.
struct MovingObstacle {
  std::string name;
  std::vector<Shape> shapes;  ///< poses in the obstacle's own frame
  ObstaclePath path;
};

}  // namespace cas::sim
