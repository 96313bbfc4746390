// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/rpc/server.hpp"
#include "casd/port/metrics_port.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {

/// Where casd's own ports are.
struct OpenPorts {
  std::string command;         ///< "127.0.0.1:5790"
  std::string command_socket;  ///< empty: none
  std::string metrics;         ///< empty: none
};

/// Opens the command port, its Unix sockets and the port of the metrics.
/// @throws base::ConfigError that names the port, and the way out if another program has it
OpenPorts open_ports(const Topology& topology, base::rpc::Server& server, MetricsPort& metrics);

/// "command_port 127.0.0.1:5790 command_socket /run/cas/casd.sock".
std::string describe(const OpenPorts& ports);

/// A Unix socket of a command port.
struct CommandSocket {
  std::filesystem::path path;
  std::string group;     ///< whose members may connect; empty: none
  bool required = true;  ///< casd does not start without it
};

/// Where the Unix sockets go: as configured, and into the runtime folder, which is made, because
/// casctl looks there for every casd that runs. In the service's folder that socket is for the
/// group `cas` where there is one. It is not required where `unix` names another place or the TCP
/// port was taken at random: such a casd is reached by its address. Stale sockets of earlier casds
/// in the folder are removed.
/// @param bound  the TCP port that casd listens on @return none with `unix: none`
/// @throws base::ConfigError
std::vector<CommandSocket> command_sockets(const CommandPortConfig& port, std::uint16_t bound);
/// Says in the log why casd has no socket in the runtime folder.
void warn_not_found(const std::string& reason);

/// The token that TCP clients must give: the file as configured, in systemd's $STATE_DIRECTORY
/// where there is one, or in the runtime folder; made where it is missing. @return empty if none is
/// required @throws base::ConfigError
std::filesystem::path command_token(const CommandPortConfig& port);

}  // namespace cas::casd
