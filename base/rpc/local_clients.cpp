// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/local_clients.hpp"

#include <filesystem>

#include "base/rpc/local_port.hpp"

namespace cas::base::rpc {

std::vector<LocalClient> connect_local() {
  std::vector<LocalClient> clients;
  for (const std::filesystem::path& path : local_command_sockets()) {
    const std::string address = "unix:" + path.string();
    try {
      clients.push_back({address, Client(address)});
    } catch (const ConnectionError&) {
      // The socket has no listener any more, or this user may not connect.
    }
  }
  return clients;
}

}  // namespace cas::base::rpc
