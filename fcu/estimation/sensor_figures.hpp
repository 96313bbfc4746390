// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/config/config.hpp"
#include "fcu/estimation/estimator_params.hpp"

namespace cas::fcu {

/// How often the sensors speak.
struct SensorRates {
  double imu_hz = 500;
  double gps_hz = 5;
  double mag_hz = 100;
  double baro_hz = 50;
};

/// What a sensor set (config/sensors/*.yaml) says of its parts: the estimator assumes it as an
/// engineer assumes a data sheet.
struct SensorFigures {
  SensorRates rates;
  EstimatorParams params;  ///< noise, walks and initial uncertainties filled in
  /// Walks without the floors that keep the filter attentive, for bounds.
  double gyro_bias_walk_rad_s = 0;
  double accel_bias_walk_m_s2 = 0;
  double baro_offset_walk_m = 0;
};

/// @param sensors  a map by plugin name, see base::sensor_set(); a missing sensor keeps the
/// defaults
/// @throws base::ConfigError for a block that its plugin would refuse, too
SensorFigures sensor_figures(const base::ConfigNode& sensors);

}  // namespace cas::fcu
