// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/open_ports.hpp"

#include <cstdint>
#include <filesystem>

#include "base/error.hpp"
#include "base/rpc/address_in_use.hpp"
#include "casd/port/port_places.hpp"

namespace cas::casd {
namespace {

std::uint16_t listen_tcp(const CommandPortConfig& port, base::rpc::Server& server) {
  const std::string what = "command port ";
  try {
    return server.listen_tcp(port.address, port.port);
  } catch (const base::rpc::AddressInUse& error) {
    throw base::ConfigError(what + error.what() +
                            "; a second casd takes another with 'command_port: {port: N}' (0: a "
                            "free one), or beside endpoints with '--command-port N'");
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(what + error.what());
  }
}

/// @return whether it listens there
bool listen_unix(const CommandSocket& socket, base::rpc::Server& server) {
  try {
    server.listen_unix(socket.path, socket.group);
    return true;
  } catch (const base::ConfigError& error) {
    if (socket.required) throw;
    warn_not_found(error.what());
    return false;
  }
}

}  // namespace

OpenPorts open_ports(const Topology& topology, base::rpc::Server& server, MetricsPort& metrics) {
  const CommandPortConfig& port = topology.command_port;
  const std::filesystem::path token = command_token(port);
  if (!token.empty()) server.require_token(token, port.loopback_without_token);
  const std::uint16_t bound = listen_tcp(port, server);
  OpenPorts open;
  open.command = port.address + ":" + std::to_string(bound);
  for (const CommandSocket& socket : command_sockets(port, bound)) {
    const bool listens = listen_unix(socket, server);
    if (listens && open.command_socket.empty()) open.command_socket = socket.path.string();
  }
  if (const auto& http = topology.metrics) {
    open.metrics = http->address + ":" + std::to_string(metrics.listen(http->address, http->port));
  }
  return open;
}

std::string describe(const OpenPorts& ports) {
  std::string text = "command_port " + ports.command;
  if (!ports.command_socket.empty()) text += " command_socket " + ports.command_socket;
  if (!ports.metrics.empty()) text += " metrics " + ports.metrics;
  return text;
}

}  // namespace cas::casd
