// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace cas::base::rpc {

/// casd's TCP port, unless configured otherwise.
inline constexpr std::uint16_t kCommandPort = 5790;
/// The token's file in a runtime folder, or in the service's state folder.
inline constexpr const char* kCommandToken = "casd.token";

/// The Unix socket's file in a runtime folder: "casd.sock" for kCommandPort, "casd-PORT.sock" for
/// another TCP port.
std::string command_socket_name(std::uint16_t port);
/// Whether a file's name is one of these: "casd.sock" or "casd-SOMETHING.sock".
bool is_command_socket_name(std::string_view name);

/// Whether an address is of this machine alone: 127.0.0.0/8, ::1 or "localhost".
bool is_loopback_address(const std::string& address);

/// Where the service keeps its token: the unit's StateDirectory.
inline constexpr const char* kServiceState = "/var/lib/cas";

/// This user's runtime folder, made with mode 0700 where it is missing.
/// @throws ConfigError when it cannot be made, is no folder, or others may write into it
std::filesystem::path make_runtime_folder();

/// Sockets of casd in the runtime folders of this machine, this user's before the service's, each
/// folder's by name. They belong to this user, to root or, in the service's folder, to the service;
/// whether a casd still listens is not asked (connect_local()).
std::vector<std::filesystem::path> local_command_sockets();
/// Token files of casd on this machine that this user may read, in the same order.
std::vector<std::filesystem::path> local_command_tokens();

}  // namespace cas::base::rpc
