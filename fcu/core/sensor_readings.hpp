// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "fcu/core/airspeed_meter.hpp"
#include "fcu/core/vibration_meter.hpp"
#include "fcu/estimation/sensor_health.hpp"
#include "mavlink/common/hil_gps.hpp"

namespace cas::fcu {

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
