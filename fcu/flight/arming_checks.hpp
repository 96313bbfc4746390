// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "base/time/clock.hpp"
#include "fcu/estimation/estimator.hpp"
#include "fcu/estimation/sensor_monitor.hpp"
#include "fcu/flight/flight_mode.hpp"
#include "fcu/params/param_binding.hpp"

namespace cas::fcu {

/// What must hold before the rotors may turn.
struct ArmingInput {
  const Estimator& estimator;
  const SensorMonitor& sensors;
  const FlightParams& params;
  FlightMode mode;
  bool has_sticks = false;
  double sticks_throttle = 0;  ///< 0..1
  double battery = 1;          ///< 0..1 of full
  base::RunTime now;
};

/// The first thing that speaks against arming, in words; nothing when all is well.
std::optional<std::string> reason_not_to_arm(const ArmingInput& in);

}  // namespace cas::fcu
