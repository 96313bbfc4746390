// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/rpc/client.hpp"
#include "hils/flight/flight_facts.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/measure/flight_changes.hpp"
#include "hils/programs/outside_hands.hpp"

namespace cas::hils {

/// Motion of a vehicle in sim.status, whose axes are W's: x east, y north.
Motion to_motion(const nlohmann::json& vehicle);

/// The vehicle that casd is asked about, by its MAVLink system; nothing: the only one there is.
using AskedVehicle = std::optional<std::uint8_t>;

/// casd's current knowledge of the vehicle; not heard if there is none yet.
VehicleReport vehicle_report(base::rpc::Client& casd, AskedVehicle vehicle = {});

/// Sends a step's commands through casd. @return why one was refused; empty if all were accepted
/// @param asked  the calls are appended to it
/// @param acts_so_far  of VehicleReport: casd does not arm if others have commanded since
std::string give(base::rpc::Client& casd, const FlightStep& step, bool not_hil,
                 AskedVehicle vehicle = {}, CallList* asked = nullptr,
                 std::optional<std::uint64_t> acts_so_far = {});

/// Acts of others on the vehicle, checked before the next arming. @param own  calls made by
/// hils
OutsideHands outside_hands(base::rpc::Client& casd, const CallList& own, AskedVehicle vehicle = {});

/// Calls of others to casd (casd.journal). @param own  calls made by hils
std::vector<OutsideCall> read_outside_calls(base::rpc::Client& casd, const CallList& own);
/// Calls of others to the simulator (sim.journal). @param own  calls made by hils
std::vector<OutsideCall> read_simulator_calls(base::rpc::Client& simulator, const CallList& own);

}  // namespace cas::hils
