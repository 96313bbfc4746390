// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/earth/gravity.hpp"

namespace cas::fcu {

/// Deviation of the velocity of a vehicle at rest, which counts as a measurement of zero.
inline constexpr double kRestVelocity_m_s = 0.01;

/// The estimator's assumptions about its sensors. Deviations are 1 sigma.
struct EstimatorParams {
  // Noise of one IMU sample, axes of D.
  Eigen::Vector3d gyro_noise_rad_s{0.0117, 0.0136, 0.0021};
  Eigen::Vector3d accel_noise_m_s2{0.04, 0.06, 0.07};
  // Random walks, per square root of a second.
  double gyro_bias_walk_rad_s = 1e-5;
  double accel_bias_walk_m_s2 = 2e-4;
  double earth_field_walk_gauss = 1e-5;
  double body_field_walk_gauss = 1e-5;
  double baro_offset_walk_m = 1e-3;
  // Noise of one measurement.
  double gps_position_noise_m = 0.3;
  double gps_height_noise_m = 0.3;
  double gps_velocity_noise_m_s = 0.1;
  double baro_noise_m = 0.087;
  double mag_noise_gauss = 0.004;
  // Uncertainty before the first measurement.
  double tilt_initial_rad = 0.1;
  double gyro_bias_initial_rad_s = 0.02;
  double accel_bias_initial_m_s2 = 0.1;
  double earth_field_initial_gauss = 0.002;
  double body_field_initial_gauss = 0.002;
  double baro_offset_initial_m = 5.0;
  // Innovations beyond this many deviations are rejected.
  double gps_position_gate = 5;
  double gps_velocity_gate = 5;
  double baro_gate = 5;
  double mag_gate = 5;
  /// Age that a position fix is taken to have when its own stamp says nothing.
  double gps_delay_s = 0;
  double gravity_m_s2 = base::kStandardGravity_m_s2;
};

}  // namespace cas::fcu
