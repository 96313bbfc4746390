// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "hils/run/station_endpoint.hpp"

namespace cas::hils {

/// Command for casctl: its name if a folder of `search_path` (PATH) has it, else its path beside
/// this program, relative to `working_folder` if below it.
std::string casctl_command(const std::filesystem::path& program_folder,
                           const std::filesystem::path& working_folder,
                           std::string_view search_path);

/// "Watch it: casctl monitor; a ground station at 127.0.0.1:14550 is sent to over UDP".
/// @param casctl  how the user's shell finds it
/// @param address  of the run's casd, where casctl needs it
std::string watch_line(const std::string& casctl, const std::optional<std::string>& address,
                       const std::optional<StationEndpoint>& station);

/// Says on standard error how to watch a run whose casd is ready. The address is in it unless
/// that casd is the only one on this machine.
/// @param command_port  the Unix socket of the run's casd
void tell_how_to_watch(const std::filesystem::path& command_port,
                       const std::optional<StationEndpoint>& station);

}  // namespace cas::hils
