// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/open_ports.hpp"

#include <fmt/format.h>
#include <grp.h>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/os/runtime_folder.hpp"
#include "base/rpc/address_in_use.hpp"
#include "base/rpc/listener.hpp"
#include "base/rpc/local_port.hpp"
#include "base/rpc/token.hpp"

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
  open.command = fmt::format("{}:{}", port.address, bound);
  for (const CommandSocket& socket : command_sockets(port, bound)) {
    const bool listens = listen_unix(socket, server);
    if (listens && open.command_socket.empty()) open.command_socket = socket.path.string();
  }
  if (const auto& http = topology.metrics) {
    open.metrics = fmt::format("{}:{}", http->address, metrics.listen(http->address, http->port));
  }
  return open;
}

std::string describe(const OpenPorts& ports) {
  std::string text = "command_port " + ports.command;
  if (!ports.command_socket.empty()) text += " command_socket " + ports.command_socket;
  if (!ports.metrics.empty()) text += " metrics " + ports.metrics;
  return text;
}

namespace {

constexpr const char* kServiceGroup = "cas";

/// The runtime folder, made; a failure names the key that does without it.
std::filesystem::path folder_for(const char* key) {
  try {
    return base::rpc::make_runtime_folder();
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(std::string(error.what()) +
                            "; or name another place with command_port." + key);
  }
}

/// A service keeps its token over a stop, at which its runtime folder goes.
std::filesystem::path default_token() {
  const char* state = std::getenv("STATE_DIRECTORY");
  const bool service = state != nullptr && *state != '\0';
  return (service ? std::filesystem::path(state) : folder_for("token_file")) /
         base::rpc::kCommandToken;
}

std::string default_group(const std::filesystem::path& folder) {
  const bool shared = folder == base::kServiceFolder && ::getgrnam(kServiceGroup) != nullptr;
  return shared ? kServiceGroup : "";
}

/// Where casctl finds this casd.
CommandSocket socket_in_runtime_folder(const CommandPortConfig& port, std::uint16_t bound) {
  const std::filesystem::path folder = folder_for("unix");
  base::rpc::remove_stale_sockets(folder);
  const bool take_default = !port.unix_path && port.unix_group.empty();
  return {.path = folder / base::rpc::command_socket_name(bound),
          .group = take_default ? default_group(folder) : port.unix_group};
}

/// The same where casd also runs without it.
std::vector<CommandSocket> optional_socket(const CommandPortConfig& port, std::uint16_t bound) {
  try {
    CommandSocket socket = socket_in_runtime_folder(port, bound);
    socket.required = false;
    return {std::move(socket)};
  } catch (const base::ConfigError& error) {
    warn_not_found(error.what());
    return {};
  }
}

/// Whether casctl sees a socket where it is.
bool is_found_at(const std::filesystem::path& path) {
  if (!base::rpc::is_command_socket_name(path.filename().native())) return false;
  std::error_code none;  // a folder that is not there is not the same
  return std::filesystem::equivalent(path.parent_path(), base::runtime_folder(), none) ||
         std::filesystem::equivalent(path.parent_path(), base::kServiceFolder, none);
}

}  // namespace

void warn_not_found(const std::string& reason) {
  base::log::warn("casctl finds this casd by its address alone: " + reason);
}

std::vector<CommandSocket> command_sockets(const CommandPortConfig& port, std::uint16_t bound) {
  if (!port.unix_path && port.port != 0) return {socket_in_runtime_folder(port, bound)};
  if (!port.unix_path) return optional_socket(port, bound);
  if (port.unix_path->empty()) return {};
  std::vector<CommandSocket> sockets{{.path = *port.unix_path, .group = port.unix_group}};
  if (is_found_at(*port.unix_path)) return sockets;
  for (CommandSocket& further : optional_socket(port, bound)) {
    sockets.push_back(std::move(further));
  }
  return sockets;
}

std::filesystem::path command_token(const CommandPortConfig& port) {
  const bool only_loopback = base::rpc::is_loopback_address(port.address);
  if (port.loopback_without_token && only_loopback && port.token_file.empty()) return {};
  const std::filesystem::path file = port.token_file.empty() ? default_token() : port.token_file;
  if (base::rpc::make_token(file))
    base::log::info("made the command port's token " + file.string());
  return file;
}

}  // namespace cas::casd
