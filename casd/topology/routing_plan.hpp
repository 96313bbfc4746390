// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <string>

#include "casd/packet/link_id.hpp"
#include "casd/routing/router.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {

/// Which slot each link has, by name.
using LinkSlots = std::map<std::string, LinkId>;
/// Slots in file order.
LinkSlots slots_in_order(const Topology& topology);

/// Compiles rules, groups and options of a topology for these slots. casd's own station hears every
/// link but the HIL streams, and may talk to every link.
std::shared_ptr<const RoutingPlan> make_plan(const Topology& topology, const LinkSlots& slots);

}  // namespace cas::casd
