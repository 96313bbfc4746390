// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "base/rpc/local_clients.hpp"

namespace cas::casctl {

/// Several casds as a table: address, topology, vehicles and start of each.
/// @param daemons  as SeveralDaemons has them
/// @param now_s  the system's clock, s since 1970
std::string daemon_table(const nlohmann::json& daemons, double now_s);

/// Asks each casd for its topology and throws the list of them.
[[noreturn]] void throw_several(std::vector<base::rpc::LocalClient>& clients);

}  // namespace cas::casctl
