// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/rpc/client.hpp"
#include "hils/flight/flight_facts.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/measure/flight_changes.hpp"

namespace cas::hils {

/// Motion of a vehicle in sim.status, whose axes are W's: x east, y north.
Motion to_motion(const nlohmann::json& vehicle);

/// Connects to casd or hilsim and introduces this program: their journals tell its calls by that.
/// @throws base::rpc::ConnectionError
base::rpc::Client connect(const std::string& address);

/// The vehicle that casd is asked about, by its MAVLink system; nullopt: the only one there is.
using AskedVehicle = std::optional<std::uint8_t>;

/// The state in an answer of casd's vehicle.state.
VehicleReport to_report(const nlohmann::json& state);
/// State of the vehicle as casd knows it now; `heard` is false if casd has not heard it yet.
VehicleReport vehicle_report(base::rpc::Client& casd, AskedVehicle vehicle = {});

/// Gives a step's commands through casd. @return why one was refused; nullopt: all were accepted
std::optional<Refusal> give(base::rpc::Client& casd, const FlightStep& step, bool not_hil,
                            AskedVehicle vehicle = {});

/// Sends the simulator the phase of the flight, for conditions of its fault scripts, if it has
/// changed. @param sent  the newest phase sent
void send_phase(base::rpc::Client& simulator, std::string_view phase, std::string& sent);

/// Calls to casd by others than hils (casd.journal). @param casd  made by connect(), as all of hils
std::vector<OutsideCall> read_outside_calls(base::rpc::Client& casd);
/// Calls to the simulator by others than hils (sim.journal). @param simulator  as above
std::vector<OutsideCall> read_simulator_calls(base::rpc::Client& simulator);

}  // namespace cas::hils
