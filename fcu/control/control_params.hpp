// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "base/angles.hpp"
#include "fcu/control/pid.hpp"

namespace cas::fcu {

/// Gains and limits of the control loops. Torques and thrust are fractions of full scale.
struct ControlParams {
  // Rates: full-scale torque per rad/s; the gains are the airframe's.
  PidGains rate_roll{.i_limit = 0.3}, rate_pitch{.i_limit = 0.3}, rate_yaw{.i_limit = 0.3};
  Eigen::Vector3d rate_feed_forward = Eigen::Vector3d::Zero();  ///< on the wanted rate
  Eigen::Vector3d rate_limit_rad_s = base::kRadPerDeg * Eigen::Vector3d(220, 220, 200);
  double gyro_cutoff_hz = 60;
  double dgyro_cutoff_hz = 30;
  // Attitude: 1/s.
  double roll_p = 7, pitch_p = 7, yaw_p = 2.8;
  double yaw_weight = 0.4;  ///< 0..1, of yaw beside tilt
  // Position: 1/s; velocity: acceleration per m/s.
  double xy_p = 1.5, z_p = 1.3;
  static constexpr double kWindLimit_m_s2 = 6;  ///< largest steady disturbance integrated away
  PidGains xy_velocity{.p = 4, .i = 0.7, .d = 0.2, .i_limit = kWindLimit_m_s2};
  PidGains z_velocity{.p = 5, .i = 2, .d = 0, .i_limit = kWindLimit_m_s2};
  double xy_velocity_limit_m_s = 12;
  double z_velocity_up_limit_m_s = 3;
  double z_velocity_down_limit_m_s = 1.5;
  double acceleration_limit_m_s2 = 8;
  double tilt_limit_rad = 45 * base::kRadPerDeg;
  // Shares of full thrust.
  double hover_thrust = 0.5;
  double thrust_min = 0.08;
  double thrust_max = 1.0;
  // Rotors.
  std::uint32_t rotors_lost = 0;   ///< bit i: leave out rotor i + 1
  bool detect_rotor_loss = false;  ///< look for rotors that give nothing
  double side_share = 0;           ///< 0..1 of the force sideways that may be used before tilting
};

}  // namespace cas::fcu
