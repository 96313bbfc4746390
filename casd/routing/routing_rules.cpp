// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/routing_rules.hpp"

#include <algorithm>

#include "casd/routing/ground_station_traffic.hpp"

namespace cas::casd {
namespace {

// Bars `to` from every entry that the lists do not let pass.
void restrict_ids(std::array<SlotMask, 256>& masks, SlotMask to,
                  const std::vector<std::uint8_t>& allow, const std::vector<std::uint8_t>& block) {
  if (!allow.empty()) {
    for (SlotMask& mask : masks) mask &= ~to;
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
  if (vehicles && !is_vehicle_traffic(packet)) return false;
  if (messages.empty() && !ground_station) return true;
  return holds(messages, packet.message_id) ||
         (ground_station && is_ground_station_traffic(packet));
}

bool AcceptRule::may_accept(std::uint32_t message_id) const {
  if (read_only || (vehicles && !may_be_of_vehicle(message_id))) return false;
  if (std::ranges::find(messages, message_id) != messages.end()) return true;
  return ground_station ? std::ranges::binary_search(ground_station_messages(), message_id)
                        : messages.empty();
}

ForwardWord::ForwardWord() {
  by_system_.fill(~SlotMask{0});
  by_component_.fill(~SlotMask{0});
}

void ForwardWord::add(const ForwardRule& rule, std::uint8_t slot) {
  const SlotMask to = slot_bit(slot);
  if (rule.allow) {
    for (const std::uint32_t id : *rule.allow) message_entry(id) |= to;
  } else {
    for (SlotMask& mask : by_message_) mask |= to;
    for (auto& [id, mask] : by_other_message_) mask |= to;
    by_default_ |= to;
  }
  for (const std::uint32_t id : rule.block) message_entry(id) &= ~to;
  restrict_ids(by_system_, to, rule.allow_systems, rule.block_systems);
  restrict_ids(by_component_, to, rule.allow_components, rule.block_components);
}

SlotMask& ForwardWord::message_entry(std::uint32_t message_id) {
  if (message_id < kTabledIds) return by_message_[message_id];
  return by_other_message_.try_emplace(message_id, by_default_).first->second;
}

void ForwardTable::add(const ForwardRule& rule) {
  auto& word = words_[LinkMask::word_of(rule.to)];
  if (!word) word = std::make_unique<ForwardWord>();
  word->add(rule, LinkMask::slot_of(rule.to));
  for (const RateRule& rate : rule.rates) limits_.push_back({rule.to, rate, limits_.size()});
}

LinkMask ForwardTable::destinations(std::uint32_t message_id, mav::Source source) const {
  LinkMask links;
  for (std::size_t word = 0; word < LinkMask::kWords; ++word) {
    links.set_word(word, destinations(word, message_id, source));
  }
  return links;
}

ForwardRules::ForwardRules(std::span<const ForwardRule> rules) {
  for (const ForwardRule& rule : rules) {
    tables_[rule.from].add(rule);
    words_ = std::max(words_, LinkMask::word_of(rule.to) + 1);
  }
}

LinkMask RateLimiter::admit(std::span<const RateLimit> limits, std::uint32_t message_id,
                            mav::Source source, LinkMask wanted, base::RunTime now) {
  for (const RateLimit& limit : limits) {
    if (limit.rule.message_id != message_id || !wanted.has(limit.to)) continue;
    if (!pass(limit.rule, state_of(limit.index, source), now)) wanted.remove(limit.to);
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
