// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/port_places.hpp"

#include <grp.h>

#include <cstdlib>
#include <optional>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/os/runtime_folder.hpp"
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

}  // namespace

CommandSocket command_socket(const CommandPortConfig& port) {
  if (port.unix_path) return {*port.unix_path, port.unix_group};
  if (port.port == 0) return {};
  const std::filesystem::path folder = folder_for("unix");
  return {folder / base::rpc::command_socket_name(port.port),
          port.unix_group.empty() ? default_group(folder) : port.unix_group};
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
