// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/angles.hpp"
#include "fcu/control/pid.hpp"

namespace cas::fcu {

/// Gains and limits of flight on a wing. Airspeeds are equivalent ones (true at sea level);
/// throttles are shares of the static thrust. What depends on the airframe comes from
/// derive_wing().
struct WingParams {
  // Rates: share of full deflection per rad/s at `airspeed_trim_m_s`.
  PidGains roll_rate{.i_limit = 0.5}, pitch_rate{.i_limit = 0.5}, yaw_rate{.i_limit = 0.5};
  Eigen::Vector3d rate_feed_forward = Eigen::Vector3d::Zero();  ///< on the wanted rate
  // Attitude: time constants and limits.
  double roll_time_s = 0.4, pitch_time_s = 0.4;
  Eigen::Vector3d rate_limit_rad_s = base::kRadPerDeg * Eigen::Vector3d(70, 60, 50);
  double roll_limit_rad = 50 * base::kRadPerDeg;
  double pitch_max_rad = 30 * base::kRadPerDeg, pitch_min_rad = -30 * base::kRadPerDeg;
  double pitch_offset_rad = 0;
  // Airspeed.
  bool use_airspeed = true;  ///< else the speed over ground
  double airspeed_min_m_s = 10, airspeed_trim_m_s = 15, airspeed_max_m_s = 20;
  // Total energy.
  double throttle_min = 0, throttle_trim = 0.1, throttle_max = 0.5;
  double climb_max_m_s = 5;  ///< at `throttle_max`
  double sink_min_m_s = 2;   ///< at `throttle_min`
  double sink_max_m_s = 5;
  double height_time_s = 3, airspeed_time_s = 4;
  double throttle_damping = 0.3, throttle_integrator = 0.15;
  double pitch_damping = 0.1, pitch_integrator = 0.15;
  double speed_weight = 1;  ///< of the pitch, 0 height alone .. 2 speed alone
  // Path.
  double path_period_s = 12, path_damping = 0.75;
  double loiter_radius_m = 80;  ///< where none is asked for
  // Take-off from a runway.
  double runway_throttle = 0.2, runway_ramp_s = 2;
  double runway_pitch_rad = 0;
  // Landing.
  double land_slope_rad = 5 * base::kRadPerDeg;
  double land_airspeed_m_s = 12;
  double flare_height_m = 2, flare_sink_m_s = 0.3;
  // Transition of a VTOL.
  double transition_airspeed_m_s = 10;  ///< the wing carries it from here on
  double blend_airspeed_m_s = 8;        ///< surfaces help the rotors from here on
  double transition_throttle = 0.2;
  double transition_timeout_s = 15;
  double back_transition_s = 10;  ///< the longest
};

}  // namespace cas::fcu
