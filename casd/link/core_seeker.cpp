// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/core_seeker.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace cas::casd {
namespace {

// A settled thread gives up when its packets cost twice as much, and by more than the noise.
constexpr int kDearer = 2;
constexpr base::Duration kNoise = std::chrono::microseconds(5);
constexpr int kDearSamples = 3;  // one may be an interrupt

// Turns of a sample: of a thread that has just moved, that tries, that stays where it is.
constexpr std::uint64_t kMovedTurns = 8;
constexpr std::uint64_t kTrialTurns = 32;
constexpr std::uint64_t kRestTurns = 128;

double per_second(std::uint64_t count, base::Duration time) {
  return static_cast<double>(count) / std::chrono::duration<double>(time).count();
}

}  // namespace

CoreSeeker::CoreSeeker(std::vector<int> cores) : cores_(std::move(cores)) {
  if (cores_.size() > kMostCores) cores_.resize(kMostCores);
}

std::uint64_t CoreSeeker::sample_turns() const {
  if (skip_) return kMovedTurns;
  return state_ == State::kTrying ? kTrialTurns : kRestTurns;
}

void CoreSeeker::take(const CoreSample& sample, base::RunTime now) {
  if (!seeks() || sample.turns == 0 || sample.elapsed <= base::Duration{}) return;
  const bool moved = std::exchange(skip_, false);
  if (!fits(sample)) return give_up(now, pause_);
  if (moved) return;
  const base::Duration cost = cost_of(sample);
  switch (state_) {
    case State::kFree:
      free_cost_ = cost;
      if (now >= next_trial_) begin_trial();
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
  if (state_ != State::kFree) give_up(now, pause_);
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

bool CoreSeeker::fits(const CoreSample& sample) {
  const double rate_hz = per_second(sample.turns, sample.elapsed);
  return rate_hz >= kLeastRate_hz && rate_hz <= kMostRate_hz &&
         std::chrono::duration<double>(sample.ran) <=
             kMostLoad * std::chrono::duration<double>(sample.elapsed) &&
         sample.queued / static_cast<std::int64_t>(sample.turns) <= kMostQueued;
}

void CoreSeeker::begin_trial() {
  state_ = State::kTrying;
  at_ = 0;
  best_ = 0;
  best_cost_ = base::Duration::max();
  skip_ = true;
}

void CoreSeeker::go_on(base::Duration cost) {
  if (cost < best_cost_) {
    best_cost_ = cost;
    best_ = at_;
  }
  ++at_;
  skip_ = true;
}

void CoreSeeker::judge(base::RunTime now) {
  const bool worthwhile = std::chrono::duration<double>(best_cost_) <
                          kWorthwhile * std::chrono::duration<double>(free_cost_);
  if (!worthwhile) return give_up(now, pause_);
  state_ = State::kSettled;
  settled_at_ = now;
  dear_ = 0;
}

// Who is heard or written to has moved: there may be a better core at once, if it lasted.
void CoreSeeker::watch(base::Duration cost, base::RunTime now) {
  dear_ = cost > kDearer * best_cost_ + kNoise ? dear_ + 1 : 0;
  if (dear_ < kDearSamples) return;
  give_up(now, now - settled_at_ >= kLasting ? base::Duration{} : pause_ / 2);
}

void CoreSeeker::give_up(base::RunTime now, base::Duration pause) {
  if (state_ == State::kFree) return;
  skip_ = true;
  const bool lasted = state_ == State::kSettled && now - settled_at_ >= kLasting;
  state_ = State::kFree;
  next_trial_ = now + pause;
  pause_ = lasted ? kShortestPause : std::min(2 * pause_, kLongestPause);
}

}  // namespace cas::casd
