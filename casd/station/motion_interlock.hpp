// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "base/time/clock.hpp"
#include "casd/station/services.hpp"
#include "casd/station/vehicle_state.hpp"
#include "casd/station/vehicle_table.hpp"

namespace cas::casd {

/// A sentence that another autopilot has the vehicle's system id; nullopt: it is alone.
std::optional<std::string> rival_words(const VehicleState& state, const VehicleTable& table,
                                       base::RunTime now);
/// Why its HEARTBEATs do not say that the vehicle flies a simulation; nullopt: they do.
std::optional<std::string> not_in_hil(const VehicleState& state, base::RunTime now);

/// Consents to spin or move a vehicle without the HIL flag. Both are required.
struct NotHilConsent {
  bool request = false;
  bool configuration = false;
};

/// Why the vehicle may not be had do this. What stops it, it may always be; what moves it, unless
/// it is armed and does not say that it is in HIL; what starts motors, if its HEARTBEATs say that
/// it flies a simulation and no second autopilot uses its id. Request and configuration together
/// consent to a vehicle that does not say so. @return nullopt: it may
std::optional<Outcome> motion_interlock(Motion motion, const VehicleState& state,
                                        const VehicleTable& table, NotHilConsent consent,
                                        base::RunTime now);

}  // namespace cas::casd
