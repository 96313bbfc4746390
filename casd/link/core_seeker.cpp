// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/core_seeker.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace cas::casd {
namespace {

// A settled thread tries the other cores when its packets cost twice as much, and by more than the
// noise, or as much as without a choice.
constexpr int kDearer = 2;
constexpr base::Duration kNoise = std::chrono::microseconds(5);
constexpr int kDearSamples = 3;  // one may be an interrupt

// Turns of a sample: right after a move; while trying, or while packets are dear; otherwise.
constexpr std::uint64_t kMovedTurns = 8;
constexpr std::uint64_t kTrialTurns = 32;
constexpr std::uint64_t kRestTurns = 128;

// The few turns after a move: one long wait must not decide.
constexpr base::Duration kMostQueuedAfterMove = 4 * CoreSeeker::kMostQueued;

double per_second(std::uint64_t count, base::Duration time) {
  return static_cast<double>(count) / std::chrono::duration<double>(time).count();
}

}  // namespace

CoreSeeker::CoreSeeker(std::vector<int> cores) : cores_(std::move(cores)) {
  if (cores_.size() > kMostCores) cores_.resize(kMostCores);
}

std::uint64_t CoreSeeker::sample_turns() const {
  if (skip_) return kMovedTurns;
  return state_ == State::kTrying || dear_ > 0 ? kTrialTurns : kRestTurns;
}

void CoreSeeker::take(const CoreSample& sample, base::RunTime now) {
  if (!seeks() || sample.turns == 0 || sample.elapsed <= base::Duration{}) return;
  const bool moved = std::exchange(skip_, false);
  if (!fits(sample, moved ? kMostQueuedAfterMove : kMostQueued)) return give_up(now);
  if (moved) return;
  const base::Duration cost = cost_of(sample);
  switch (state_) {
    case State::kFree:
      free_cost_ = cost;
      if (now >= next_trial_) begin_trial(now);
      return;
    case State::kTrying:
      go_on(cost);
      if (at_ == cores_.size()) judge(now);
      return;
    case State::kSettled:
      watch(cost, now);
      return;
  }
}

void CoreSeeker::release(base::RunTime now) {
  if (state_ != State::kFree) give_up(now);
}

std::optional<int> CoreSeeker::core() const {
  if (state_ == State::kTrying) return cores_[at_];
  if (state_ == State::kSettled) return cores_[best_];
  return std::nullopt;
}

base::Duration CoreSeeker::cost_of(const CoreSample& sample) {
  const auto turns = static_cast<std::int64_t>(sample.turns);
  const base::Duration queued = sample.queued / turns;
  const base::Duration until_it_runs =
      sample.stamped > 0
          ? std::max(queued, sample.arrival / static_cast<std::int64_t>(sample.stamped))
          : queued;
  return sample.ran / turns + until_it_runs;
}

bool CoreSeeker::fits(const CoreSample& sample, base::Duration most_queued) {
  const double rate_hz = per_second(sample.turns, sample.elapsed);
  return rate_hz >= kLeastRate_hz && rate_hz <= kMostRate_hz &&
         std::chrono::duration<double>(sample.ran) <=
             kMostLoad * std::chrono::duration<double>(sample.elapsed) &&
         sample.queued / static_cast<std::int64_t>(sample.turns) <= most_queued;
}

void CoreSeeker::begin_trial(base::RunTime now) {
  trial_began_ = now;
  best_cost_ = base::Duration::max();
  try_next(0);
}

// Tries all cores but the present one, where a packet now costs `cost`.
void CoreSeeker::try_others(base::Duration cost, base::RunTime now) {
  trial_began_ = now;
  known_ = best_;
  best_cost_ = cost;
  try_next(0);
}

void CoreSeeker::try_next(std::size_t at) {
  state_ = State::kTrying;
  at_ = at == known_ ? at + 1 : at;
  skip_ = true;
  dear_ = 0;
}

void CoreSeeker::go_on(base::Duration cost) {
  if (cost < best_cost_) {
    best_cost_ = cost;
    best_ = at_;
  }
  try_next(at_ + 1);
}

void CoreSeeker::judge(base::RunTime now) {
  const bool worthwhile = std::chrono::duration<double>(best_cost_) <
                          kWorthwhile * std::chrono::duration<double>(free_cost_);
  if (!worthwhile || best_ == known_) return give_up(now);
  state_ = State::kSettled;
  settled_at_ = now;
}

// The peer has moved: it is followed, unless it moves all the time.
void CoreSeeker::watch(base::Duration cost, base::RunTime now) {
  const bool dear = cost > kDearer * best_cost_ + kNoise || cost >= free_cost_;
  dear_ = dear ? dear_ + 1 : 0;
  if (dear_ < kDearSamples) return;
  const base::Duration worth_a_trial = std::max(kShortestPause, settled_at_ - trial_began_);
  if (now - settled_at_ < worth_a_trial) return give_up(now);
  try_others(cost, now);
}

void CoreSeeker::give_up(base::RunTime now) {
  if (state_ == State::kFree) return;
  const bool lasted = state_ == State::kSettled && now - settled_at_ >= kLasting;
  if (lasted) pause_ = kShortestPause;
  next_trial_ = now + pause_;
  pause_ = std::min(2 * pause_, kLongestPause);
  state_ = State::kFree;
  skip_ = true;
  dear_ = 0;
  known_.reset();
}

}  // namespace cas::casd
