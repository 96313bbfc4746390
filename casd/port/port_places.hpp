// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "casd/topology/topology.hpp"

namespace cas::casd {

/// The Unix socket of a command port.
struct CommandSocket {
  std::filesystem::path path;  ///< empty: none
  std::string group;           ///< whose members may connect; empty: none
};

/// Where the Unix socket goes: as configured, else into the runtime folder, which is made. In the
/// service's folder it is for the group `cas` where there is one. A port that was taken at random
/// has none: whoever starts casd so names one. @throws base::ConfigError
CommandSocket command_socket(const CommandPortConfig& port);

/// The token that TCP clients must give: the file as configured, in systemd's $STATE_DIRECTORY
/// where there is one, or in the runtime folder; made where it is missing. @return empty when
/// nobody needs one @throws base::ConfigError
std::filesystem::path command_token(const CommandPortConfig& port);

}  // namespace cas::casd
