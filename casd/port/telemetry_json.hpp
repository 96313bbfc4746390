// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/time/clock.hpp"
#include "casd/station/vehicle_state.hpp"

namespace cas::casd {

/// The answer of vehicle.telemetry: the vehicle's measurements, by topic, with units in the keys.
/// Every topic has every key; a value that the vehicle has not sent, or sent as unknown, is null.
/// `age_s` is the age of the message that a topic comes from.
nlohmann::json telemetry_json(const VehicleState& vehicle, base::RunTime now);

}  // namespace cas::casd
