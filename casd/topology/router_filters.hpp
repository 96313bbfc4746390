// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "casd/topology/router_config.hpp"

namespace cas::casd {

/// What one endpoint lets in and out, as far as a route says it.
struct RouterFilters {
  using Ids = RouterConfig::Ids;

  Ids allow_messages_out, block_messages_out, block_messages_in;
  Ids allow_systems_out, block_systems_out;
  Ids allow_components_out, block_components_out, allow_components_in, block_components_in;
};

/// The keys of casd's route between two endpoints, ", block: [...]": what both allow, and nothing
/// that one of them blocks. Without an allow list sensor data of a simulator is blocked, too: it
/// would fly a vehicle in HIL.
std::string rule_between(const RouterFilters& from, const RouterFilters& to);

/// "allow: [HEARTBEAT, ATTITUDE]". @param messages  names for ids that have one
std::string id_list(const char* key, const RouterConfig::Ids& list, bool messages);

}  // namespace cas::casd
