// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <optional>

namespace cas::fcu {

/// A component that is not asked for.
inline constexpr double kUnset = std::numeric_limits<double>::quiet_NaN();
/// Three of them.
inline Eigen::Vector3d unset3() { return Eigen::Vector3d::Constant(kUnset); }

/// Setpoint of the position and velocity loops. A component that is NaN is not controlled
/// (position) or not fed forward (velocity, acceleration); velocity without position is followed by
/// itself.
struct TrajectorySetpoint {
  Eigen::Vector3d p_N = unset3();  ///< m
  Eigen::Vector3d v_N = unset3();  ///< m/s
  Eigen::Vector3d a_N = unset3();  ///< m/s^2
  double yaw_rad = kUnset;         ///< heading of Dx from north
  double yaw_rate_rad_s = kUnset;  ///< about Nz
};

/// Setpoint of the attitude controller.
struct AttitudeSetpoint {
  Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();  ///< turns vectors from D into N
  double yaw_rate_rad_s = 0;                                 ///< about Nz, fed forward
  double thrust_n = 0;                                       ///< along -Dz
};

/// Everything a mode may ask for. Exactly one of the members counts, outermost first.
struct ControlSetpoint {
  std::optional<TrajectorySetpoint> trajectory;
  std::optional<AttitudeSetpoint> attitude;
  double tilt_limit_rad = kUnset;  ///< of a trajectory: the less of this and the vehicle's own
  bool near_ground = false;        ///< about to leave or to touch it: nothing may wind up, nor lift
  bool may_touch = false;          ///< taking off or landing: the ground may push it
  bool idle = false;               ///< rotors at idle speed: armed on the ground
  bool stopped = false;            ///< no output at all
};

}  // namespace cas::fcu
