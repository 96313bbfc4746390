// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <optional>

#include "fcu/control/path_guidance.hpp"

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

/// Setpoint of flight on a wing: a path, a height and an airspeed. Attitude or throttle that is set
/// here replaces what these three ask for.
struct WingSetpoint {
  Path path;
  double z_m = 0;               ///< wanted z (down) in N
  double climb_m_s = 0;         ///< change of the wanted height
  bool by_climb_alone = false;  ///< `climb_m_s` counts, height and airspeed do not
  double airspeed_m_s = 0;      ///< equivalent
  double roll_rad = kUnset;     ///< instead of the path's
  double pitch_rad = kUnset;    ///< instead of that of height and airspeed
  double throttle = kUnset;     ///< instead of that of height and airspeed
  double alpha_rad = kUnset;    ///< angle of attack to balance, where it is not the weight's
  double heading_rad = kUnset;  ///< steered to on the ground
  double roll_limit_rad = kUnset;
  bool unloaded = false;  ///< wheels or rotors carry it: nothing may wind up
};

/// Everything a mode may ask for: a trajectory, an attitude, or the height of a trajectory in an
/// attitude. The wing's setpoint flies alone, or beside them in a transition.
struct ControlSetpoint {
  std::optional<TrajectorySetpoint> trajectory;
  std::optional<AttitudeSetpoint> attitude;
  std::optional<WingSetpoint> wing;
  double thrust_min_n = kUnset;  ///< of the rotors that lift; NaN: the vehicle's own
  double wing_lift_n = 0;  ///< that the wing gives beside the rotors, for a height in an attitude
  double tilt_limit_rad = kUnset;  ///< of a trajectory: the less of this and the vehicle's own
  bool near_ground = false;        ///< about to leave or to touch it: nothing may wind up, nor lift
  bool may_touch = false;          ///< taking off or landing: the ground may push it
  bool idle = false;               ///< rotors at idle speed: armed on the ground
  bool stopped = false;            ///< no output at all
};

}  // namespace cas::fcu
