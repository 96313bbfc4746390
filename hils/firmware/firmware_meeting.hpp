// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "hils/firmware/flight_deck.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// Why a firmware of this version is not flown; nullopt: it may be. @param version  empty: unknown
std::optional<std::string> version_fault(const Firmware& wanted, const std::string& version);

/// Waits for the first HEARTBEAT of a vehicle, and asks for its version and its parameters, which
/// go into its record.
/// @param vehicle  its place in the world
/// @return why it may not be flown
/// @throws RunStopped where no HEARTBEAT comes, or one from a firmware of another kind
std::optional<std::string> meet_firmware(FlightDeck& deck, std::size_t vehicle, AskedVehicle asked,
                                         RunRecord& record);

}  // namespace cas::hils
