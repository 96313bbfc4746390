// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "hils/firmware/flight_deck.hpp"
#include "hils/programs/pilot_calls.hpp"

namespace cas::hils {

/// Name of the turns by which hils sees that a board follows the simulated motion, as a fault of
/// plugin fault.
inline constexpr std::string_view kIdentification = "identification";

/// Prepares a stock ArduPilot that takes its sensors from plugin external_ahrs: waits until its
/// driver has asked for packets, calibrates the accelerometers as they are (simple calibration,
/// level), sees whether the attitude that it reports follows the simulated rates, and calibrates
/// the compass by its true heading. Whoever fails it must not be armed: ArduPilot has no HIL mode,
/// and its outputs are live.
/// @param name  of the vehicle in the simulation
/// @return why it cannot be flown; nullopt: it can
std::optional<std::string> prepare_external_ahrs(FlightDeck& deck, AskedVehicle vehicle,
                                                 const std::string& name);

/// Figures of a vehicle's plugin external_ahrs now. @throws base::rpc::ConnectionError
nlohmann::json external_ahrs_unit(FlightDeck& deck, const std::string& name);

/// Says on standard error, in red on a terminal, that the outputs are live.
void warn_of_live_outputs();

}  // namespace cas::hils
