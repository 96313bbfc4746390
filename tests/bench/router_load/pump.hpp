// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace router_load {

/// The trivial reference router: one thread, poll(2), one datagram or read per turn, no framing.
[[noreturn]] void pump_main(const std::string& slave, int port);

/// The least that a router can do: a thread for each direction that blocks in read(2) and writes
/// what it got, one packet or many. Serves no ground stations.
[[noreturn]] void relay_main(const std::string& slave, int port);

}  // namespace router_load
