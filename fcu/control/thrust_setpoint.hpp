// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "fcu/control/setpoint.hpp"

namespace cas::fcu {

/// What the vehicle may be asked for.
struct ThrustLimits {
  double min_n = 0;     ///< along -Dz
  double max_n = 0;     ///< along -Dz
  double tilt_rad = 0;  ///< of -Dz from up
};

/// Attitude and thrust that give an acceleration, and what the limits took away.
struct ThrustSetpoint {
  AttitudeSetpoint attitude;
  bool thrust_at_max = false;
  bool thrust_at_min = false;
  Eigen::Vector2d cut_N = Eigen::Vector2d::Zero();  ///< horizontal force not given, N
};

/// Force m (a - g) as a direction for -Dz and a magnitude. When thrust runs out, height comes
/// before horizontal acceleration.
/// @param a_N        wanted acceleration, m/s^2
/// @param mass_kg    m
/// @param gravity    m/s^2, positive
/// @param yaw        heading of Dx, rad
ThrustSetpoint thrust_for_acceleration(const Eigen::Vector3d& a_N, double mass_kg, double gravity,
                                       double yaw, const ThrustLimits& limits);

/// Attitude whose -Dz points along `up_N` (any length) and whose Dx heads to `yaw`.
Eigen::Quaterniond attitude_from_direction(const Eigen::Vector3d& up_N, double yaw);

}  // namespace cas::fcu
