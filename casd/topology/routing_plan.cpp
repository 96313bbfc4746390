// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/routing_plan.hpp"

#include <cstdint>
#include <iterator>
#include <vector>

#include "casd/packet/link_mask.hpp"
#include "casd/topology/message_keys.hpp"

namespace cas::casd {
namespace {

// The HIL streams are not casd's business; everything else may be.
void add_station(std::vector<ForwardRule>& rules, const Topology& topology,
                 const LinkSlots& slots) {
  const std::vector<std::uint32_t> hil = hil_messages();
  for (const LinkConfig& config : topology.links) {
    if (config.sniffer) continue;  // gets the station's packets without a rule
    const LinkId link = slots.at(config.name);
    ForwardRule& hears = rules.emplace_back();
    hears.from = link;
    hears.to = kLocalLink;
    hears.block = hil;
    ForwardRule& talks = rules.emplace_back();
    talks.from = kLocalLink;
    talks.to = link;
  }
}

// Links of one group never hear each other; a link never hears itself, unless a route says that
// the peers of a server talk to each other.
void fill_groups(RoutingPlan& plan, const Topology& topology, const LinkSlots& slots) {
  std::map<std::string, LinkMask> members;
  for (const LinkConfig& link : topology.links) {
    if (!link.group.empty()) members[link.group].add(slots.at(link.name));
  }
  for (const LinkConfig& link : topology.links) {
    const LinkId id = slots.at(link.name);
    plan.never_back[id] = bit(id);
    if (link.group.empty()) continue;
    const auto group = members.find(link.group);
    plan.never_back[id] = group->second;
    plan.group[id] = static_cast<std::int16_t>(std::distance(members.begin(), group));
  }
  for (const RouteConfig& route : topology.routes) {
    if (route.from == route.to) plan.never_back[slots.at(route.from)].remove(slots.at(route.from));
  }
  plan.never_back[kLocalLink] = bit(kLocalLink);
}

}  // namespace

LinkSlots slots_in_order(const Topology& topology) {
  LinkSlots slots;
  LinkMask taken = bit(kLocalLink);
  for (const LinkConfig& link : topology.links) {
    const LinkId slot = taken.first_missing();
    slots.emplace(link.name, slot);
    taken.add(slot);
  }
  return slots;
}

std::shared_ptr<const RoutingPlan> make_plan(const Topology& topology, const LinkSlots& slots) {
  auto plan = std::make_shared<RoutingPlan>();
  std::vector<ForwardRule> rules;
  for (const RouteConfig& route : topology.routes) {
    rules.push_back(route.rule);
    rules.back().from = slots.at(route.from);
    rules.back().to = slots.at(route.to);
  }
  add_station(rules, topology, slots);
  plan->rules = ForwardRules(rules);
  fill_groups(*plan, topology, slots);
  plan->duplicate_window = topology.duplicate_window;
  for (const LinkConfig& link : topology.links) {
    if (link.pass_unknown) plan->pass_unknown.add(slots.at(link.name));
    if (link.sniffer) plan->sniffers.add(slots.at(link.name));
    if (link.type == LinkType::kTlog) plan->recordings.add(slots.at(link.name));
    if (link.to_not_hil == ToNotHil::kStopsOnly) plan->stops_only.add(slots.at(link.name));
  }
  plan->holds_back = !plan->stops_only.empty();
  return plan;
}

}  // namespace cas::casd
