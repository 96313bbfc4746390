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

/// Why a command must not be sent to the vehicle. Commands that stop it are always allowed.
/// Commands that move it are refused while it is armed and its HEARTBEATs do not say that it is in
/// HIL. Commands that start motors need HEARTBEATs that say so, and no second autopilot with its
/// id. Request and configuration together consent to a vehicle that is not in HIL.
/// @return nullopt: the command is allowed
std::optional<Outcome> motion_interlock(Motion motion, const VehicleState& state,
                                        const VehicleTable& table, NotHilConsent consent,
                                        base::RunTime now);

}  // namespace cas::casd
