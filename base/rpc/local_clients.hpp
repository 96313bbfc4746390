// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "base/rpc/client.hpp"

namespace cas::base::rpc {

/// A casd of this machine that took the connection.
struct LocalClient {
  std::string address;  ///< "unix:PATH", as Client takes it
  Client client;
};

/// Connects to each casd that has a socket in this user's runtime folder or the service's, in the
/// order of local_command_sockets(). Leaves out sockets without a listener and those that this user
/// may not use.
std::vector<LocalClient> connect_local();

}  // namespace cas::base::rpc
