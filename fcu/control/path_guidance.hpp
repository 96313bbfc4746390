// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <variant>

namespace cas::fcu {

/// A straight path that goes on beyond both points, horizontal, m.
struct LinePath {
  Eigen::Vector2d from_N = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_N = Eigen::Vector2d::UnitX();

  Eigen::Vector2d direction() const { return (to_N - from_N).stableNormalized(); }
  /// How far a place is beyond `to_N`, m; below 0 before it.
  double beyond_m(const Eigen::Vector2d& p_N) const { return (p_N - to_N).dot(direction()); }
};

/// A circle; a radius above 0 is flown clockwise, seen from above.
struct CirclePath {
  Eigen::Vector2d centre_N = Eigen::Vector2d::Zero();
  double radius_m = 80;
};

using Path = std::variant<LinePath, CirclePath>;

/// How hard a path is followed: the period and the damping ratio of small deviations.
struct PathGains {
  double period_s = 15;
  double damping = 0.75;
};

/// Acceleration to the right of the velocity, m/s^2, that takes a vehicle onto a path and along it.
///
/// A line is followed by aiming at the point of it that lies L1 = damping period speed / pi ahead
/// (S. Park, J. Deyst, J. P. How, "A New Nonlinear Guidance Logic for Trajectory Tracking", AIAA
/// 2004-4900, with the gain 4 damping^2 of that law's linear form). A circle is met by aiming at
/// its middle and flown by its centripetal acceleration, with proportional and derivative action on
/// the distance: it has no steady error.
/// @param v_N  velocity over ground, m/s
double path_acceleration_m_s2(const Path& path, const PathGains& gains, const Eigen::Vector2d& p_N,
                              const Eigen::Vector2d& v_N);

}  // namespace cas::fcu
