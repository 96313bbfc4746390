// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

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

}  // namespace cas::casd
