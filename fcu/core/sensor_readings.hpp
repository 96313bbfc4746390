// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "fcu/core/airspeed_meter.hpp"
#include "fcu/estimation/sensor_health.hpp"
#include "mavlink/common/hil_gps.hpp"

namespace cas::fcu {

/// How rough the ride is, for VIBRATION: deviation of the specific force from its own mean.
struct VibrationMeter {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();    ///< specific force in D, m/s^2
  Eigen::Vector3d square = Eigen::Vector3d::Zero();  ///< of its deviation, m^2/s^4

  void update(const Eigen::Vector3d& accel_D) {
    constexpr double kShare = 0.002;
    const Eigen::Vector3d off = accel_D - mean;
    mean += kShare * off;
    square += kShare * (off.cwiseAbs2() - square);
  }
};

/// The newest of each sensor, and how it does.
struct SensorReadings {
  SensorHealth health;
  VibrationMeter vibration;
  AirspeedMeter airspeed;
  std::optional<mavlink::common::HilGps> gps;
  double pressure_hpa = 0;
  double temperature_degc = 0;
};

}  // namespace cas::fcu
