// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/routing/forward_rule.hpp"

namespace cas::casd {

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
