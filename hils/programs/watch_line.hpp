// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "hils/run/station_endpoint.hpp"

namespace cas::hils {

/// "Watch it: casctl monitor; a ground station at 127.0.0.1:14550 is sent to over UDP".
/// @param address  of the run's casd, where casctl needs it
std::string watch_line(const std::optional<std::string>& address,
                       const std::optional<StationEndpoint>& station);

/// Says on standard error how to watch a run whose casd is ready. The address is in it unless
/// that casd is the only one on this machine.
/// @param command_port  the Unix socket of the run's casd
void tell_how_to_watch(const std::filesystem::path& command_port,
                       const std::optional<StationEndpoint>& station);

}  // namespace cas::hils
