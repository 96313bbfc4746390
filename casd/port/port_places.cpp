// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/port_places.hpp"

#include <grp.h>

#include <cstdlib>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/os/runtime_folder.hpp"
#include "base/rpc/listener.hpp"
#include "base/rpc/local_port.hpp"
#include "base/rpc/token.hpp"

namespace cas::casd {
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
