// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/routing_rules.hpp"

#include <algorithm>

#include "casd/routing/ground_station_traffic.hpp"

namespace cas::casd {
namespace {

// Bars `to` from every entry that the lists do not let pass.
void restrict_ids(std::array<LinkMask, 256>& masks, LinkMask to,
                  const std::vector<std::uint8_t>& allow, const std::vector<std::uint8_t>& block) {
  if (!allow.empty()) {
    for (LinkMask& mask : masks) mask &= ~to;
    for (const std::uint8_t id : allow) masks[id] |= to;
  }
  for (const std::uint8_t id : block) masks[id] &= ~to;
}

}  // namespace

bool AcceptRule::accepts(const mav::PacketView& packet) const {
  const auto holds = [](const auto& list, auto value) {
    return std::find(list.begin(), list.end(), value) != list.end();
  };
  const std::uint8_t sender = packet.source.system;
  if (read_only || holds(block_systems, sender)) return false;
  if (!systems.empty() && !holds(systems, sender)) return false;
  if (messages.empty() && !ground_station) return true;
  return holds(messages, packet.message_id) ||
         (ground_station && is_ground_station_traffic(packet));
}

ForwardTable::ForwardTable() {
  by_system_.fill(~LinkMask{0});
  by_component_.fill(~LinkMask{0});
}

void ForwardTable::add(const ForwardRule& rule) {
  const LinkMask to = bit(rule.to);
  if (rule.allow) {
    for (const std::uint32_t id : *rule.allow) message_entry(id) |= to;
  } else {
    for (LinkMask& mask : by_message_) mask |= to;
    for (auto& [id, mask] : by_other_message_) mask |= to;
    by_default_ |= to;
  }
  for (const std::uint32_t id : rule.block) message_entry(id) &= ~to;
  restrict_ids(by_system_, to, rule.allow_systems, rule.block_systems);
  restrict_ids(by_component_, to, rule.allow_components, rule.block_components);
  for (const RateRule& rate : rule.rates) limits_.push_back({rule.to, rate, limits_.size()});
}

LinkMask ForwardTable::limited(std::uint32_t message_id) const {
  LinkMask mask = 0;
  for (const RateLimit& limit : limits_) {
    if (limit.rule.message_id == message_id) mask |= bit(limit.to);
  }
  return mask;
}

LinkMask& ForwardTable::message_entry(std::uint32_t message_id) {
  if (message_id < kTabled) return by_message_[message_id];
  return by_other_message_.try_emplace(message_id, by_default_).first->second;
}

ForwardRules::ForwardRules(std::span<const ForwardRule> rules) {
  for (const ForwardRule& rule : rules) tables_[rule.from].add(rule);
}

LinkMask RateLimiter::admit(std::span<const RateLimit> limits, std::uint32_t message_id,
                            mav::Source source, LinkMask wanted, base::RunTime now) {
  for (const RateLimit& limit : limits) {
    if (limit.rule.message_id != message_id || (wanted & bit(limit.to)) == 0) continue;
    if (!pass(limit.rule, state_of(limit.index, source), now)) wanted &= ~bit(limit.to);
  }
  return wanted;
}

RateLimiter::State& RateLimiter::state_of(std::size_t limit, mav::Source source) {
  std::vector<State>& states = states_[limit];
  for (State& state : states) {
    if (state.source == source) return state;
  }
  if (states.size() < kMaxSources) states.push_back({.source = source, .next = {}});
  return states.back();
}

bool RateLimiter::pass(const RateRule& rule, State& state, base::RunTime now) {
  const bool turn = state.seen % rule.every == 0;
  state.seen = (state.seen + 1) % rule.every;
  if (!turn) return false;
  if (rule.max_hz <= 0) return true;
  if (state.started && now < state.next) return false;
  const base::Duration period = base::from_seconds(1.0 / rule.max_hz);
  // On the grid while packets keep coming; a pause starts a new grid instead of a burst.
  const bool on_grid = state.started && now - state.next < period;
  state.next = (on_grid ? state.next : now) + period;
  state.started = true;
  return true;
}

}  // namespace cas::casd
