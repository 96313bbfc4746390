// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/rate_limiter.hpp"

namespace cas::casd {

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
