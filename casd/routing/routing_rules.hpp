// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/packet/link_mask.hpp"
#include "casd/packet/packet_info.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// The packets that a link takes in (`accept`), before any route is considered. By default all.
struct AcceptRule {
  bool read_only = false;  ///< takes in nothing: its peers may only listen
  /// Only traffic of ground stations (`traffic`), and `messages`.
  bool ground_station = false;
  bool vehicles = false;  ///< only what vehicles say: a played log without its `commands`
  std::vector<std::uint32_t> messages{};      ///< only these; empty: all
  std::vector<std::uint8_t> systems{};        ///< only of these senders; empty: all
  std::vector<std::uint8_t> block_systems{};  ///< not of these senders

  bool accepts(const mav::PacketView& packet) const;
  /// Whether any packet of this message may pass; accepts() decides by sender and content.
  bool may_accept(std::uint32_t message_id) const;

  friend bool operator==(const AcceptRule&, const AcceptRule&) = default;
};

/// Thins out one message of one route.
struct RateRule {
  std::uint32_t message_id = 0;
  double max_hz = 0;   ///< 0: no limit by time
  unsigned every = 1;  ///< 1: each packet, n: every n-th

  friend bool operator==(const RateRule&, const RateRule&) = default;
};

/// What may go from one link to another ([HILS] Sect. 3.3, "forward status"). Everything that is
/// not blocked passes; where an allow list is given, only what it names.
struct ForwardRule {
  LinkId from = kNoLink;
  LinkId to = kNoLink;
  std::optional<std::vector<std::uint32_t>> allow;
  std::vector<std::uint32_t> block;
  std::vector<std::uint8_t> allow_systems;  ///< of the sender; empty: all
  std::vector<std::uint8_t> block_systems;
  std::vector<std::uint8_t> allow_components;
  std::vector<std::uint8_t> block_components;
  std::vector<RateRule> rates;

  friend bool operator==(const ForwardRule&, const ForwardRule&) = default;
};

/// A rate rule together with the destination it guards.
struct RateLimit {
  LinkId to = kNoLink;
  RateRule rule;
  std::size_t index = 0;  ///< of its state, counted per source link
};

/// The rules of one source link towards 64 others, turned round: for a message id, a system and a
/// component the set of links that may have it. Three loads and two ands, whatever the number of
/// links and rules.
class ForwardWord {
 public:
  ForwardWord();
  /// @param slot  of the rule's destination
  void add(const ForwardRule& rule, std::uint8_t slot);

  SlotMask destinations(std::uint32_t message_id, mav::Source source) const {
    return by_message(message_id) & by_system_[source.system] & by_component_[source.component];
  }

 private:
  SlotMask by_message(std::uint32_t message_id) const {
    if (message_id < kTabledIds) return by_message_[message_id];
    const auto found = by_other_message_.find(message_id);
    return found == by_other_message_.end() ? by_default_ : found->second;
  }
  SlotMask& message_entry(std::uint32_t message_id);

  std::array<SlotMask, kTabledIds> by_message_{};
  std::unordered_map<std::uint32_t, SlotMask> by_other_message_;
  SlotMask by_default_ = 0;  ///< for ids above the table that no rule names
  std::array<SlotMask, 256> by_system_;
  std::array<SlotMask, 256> by_component_;
};

/// The rules of one source link. Memory is taken for words of a LinkMask that rules lead to.
class ForwardTable {
 public:
  void add(const ForwardRule& rule);

  /// The links of one word of a LinkMask that may have it.
  SlotMask destinations(std::size_t word, std::uint32_t message_id, mav::Source source) const {
    return words_[word] ? words_[word]->destinations(message_id, source) : 0;
  }
  /// All of them.
  LinkMask destinations(std::uint32_t message_id, mav::Source source) const;
  std::span<const RateLimit> limits() const { return limits_; }

 private:
  std::array<std::unique_ptr<ForwardWord>, LinkMask::kWords> words_;
  std::vector<RateLimit> limits_;
};

/// The rules of all links: an immutable snapshot once built, as a part of the plan that Router
/// decides by. A new topology brings a new one.
class ForwardRules {
 public:
  ForwardRules() = default;
  explicit ForwardRules(std::span<const ForwardRule> rules);
  const ForwardTable& from(LinkId link) const { return tables_[link]; }
  /// Words of a LinkMask that rules lead to.
  std::size_t words() const { return words_; }

 private:
  std::array<ForwardTable, kLinkSlots> tables_;
  std::size_t words_ = 0;
};

/// Applies the rate rules of one source link. `max_hz` lets a packet pass when its turn on a grid
/// of that rate has come (so 50 of 500 a second come out evenly, whatever the jitter); `every`
/// lets each n-th pass, the first one included.
class RateLimiter {
 public:
  RateLimiter() = default;
  explicit RateLimiter(std::size_t limits) : states_(limits) {}

  /// @return the links of `wanted` that may have this packet
  LinkMask admit(std::span<const RateLimit> limits, std::uint32_t message_id, mav::Source source,
                 LinkMask wanted, base::RunTime now);

 private:
  static constexpr std::size_t kMaxSources = 256;  ///< beyond that, senders share the last state

  // Each sender is thinned out by itself: one vehicle never takes another one's turn.
  struct State {
    mav::Source source;
    unsigned seen = 0;
    base::RunTime next;
    bool started = false;
  };
  State& state_of(std::size_t limit, mav::Source source);
  static bool pass(const RateRule& rule, State& state, base::RunTime now);

  std::vector<std::vector<State>> states_;
};

}  // namespace cas::casd
