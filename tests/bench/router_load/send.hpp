// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/router_load/wire.hpp"

namespace router_load {

struct Item {
  Flow f;
  double hz;
  int64_t due;
};

/// One packet of a flow. @return false when it could not be sent
bool send_flow(Flow f);
/// Streams at fixed rates until `t_end`.
void tx_paced(std::vector<Item> items, int64_t t_end);
/// As fast as possible, with --window at most so many unanswered; a heartbeat each second.
void tx_flood(Flow f, Flow hb, int64_t t_end);
/// Each client's heartbeat: so the router learns it.
void heartbeats_from_clients();

}  // namespace router_load
