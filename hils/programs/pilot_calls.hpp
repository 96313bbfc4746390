// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/rpc/client.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/measure/flight_changes.hpp"

namespace cas::hils {

/// Connects to casd or hilsim and introduces this program: their journals tell its calls by that.
/// @throws base::rpc::ConnectionError
base::rpc::Client connect(const std::string& address);

/// The vehicle that casd is asked about, by its MAVLink system; nullopt: the only one there is.
using AskedVehicle = std::optional<std::uint8_t>;
/// The parameters of a call that means this vehicle.
nlohmann::json about(AskedVehicle vehicle, nlohmann::json params);

/// The state in an answer of casd's vehicle.state.
VehicleReport to_report(const nlohmann::json& state);
/// State of the vehicle as casd knows it now; `heard` is false if casd has not heard it yet.
VehicleReport vehicle_report(base::rpc::Client& casd, AskedVehicle vehicle = {});

/// A method of casd's command port and its parameters.
using CasdCall = std::pair<std::string, nlohmann::json>;
/// Calls of casd that have a vehicle do a step, one after the other; none where casd has no part in
/// it. @param not_hil    consent to a vehicle that does not say that it is in HIL
///     @param autopilot  as casd names it; empty: ours
std::vector<CasdCall> step_calls(const FlightStep& step, bool not_hil, AskedVehicle vehicle,
                                 std::string_view autopilot = {});
/// Gives a step's commands through casd. @return why one was refused; nullopt: all were accepted
std::optional<Refusal> give(base::rpc::Client& casd, const FlightStep& step, bool not_hil,
                            AskedVehicle vehicle = {}, std::string_view autopilot = {});

/// Calls to casd by others than hils (casd.journal). @param casd  made by connect(), as all of hils
std::vector<OutsideCall> read_outside_calls(base::rpc::Client& casd);
/// Calls to the simulator by others than hils (sim.journal). @param simulator  as above
std::vector<OutsideCall> read_simulator_calls(base::rpc::Client& simulator);

}  // namespace cas::hils
