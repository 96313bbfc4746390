// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/pacer.hpp"

#include <gtest/gtest.h>

namespace cas::sim {
namespace {

using namespace std::chrono_literals;

constexpr base::RunTime kEpoch{100s};
constexpr base::Duration kStep = 1ms;

base::SimTime at(base::Duration d) { return base::SimTime(d); }

/// Wall clock when `steps` steps have been made by an obedient loop whose work takes no time.
base::RunTime run(Pacer& pacer, base::RunTime now, int first, int steps) {
  for (int i = first; i < first + steps; ++i) {
    now = std::max(now, pacer.start_of(at(i * kStep)));
    pacer.on_start(now, at(i * kStep));
  }
  return now;
}

TEST(Pacer, DeadlinesAreAbsolute) {
  Pacer pacer({}, kStep);
  pacer.restart(kEpoch, at(0s));
  run(pacer, kEpoch, 0, 100);
  // 0.3 ms late does not move the next.
  pacer.on_start(kEpoch + 100ms + 300us, at(100ms));
  EXPECT_EQ(pacer.start_of(at(102ms)), kEpoch + 102ms);
  EXPECT_EQ(pacer.late_steps(), 0u);
}

TEST(Pacer, SpeedScalesTheWallClock) {
  for (const double speed : {0.1, 1.0, 3.0, 20.0}) {
    Pacer pacer({.speed = speed}, kStep);
    pacer.restart(kEpoch, at(5s));
    const auto due = pacer.start_of(at(6s)) - kEpoch;
    EXPECT_NEAR(base::to_seconds(due), 1.0 / speed, 1e-9);
  }
}

TEST(Pacer, CatchesUpGentlyNeverInABurst) {
  Pacer pacer({.catch_up_rate = 1.25}, kStep);
  pacer.restart(kEpoch, at(0s));
  run(pacer, kEpoch, 0, 100);
  // A stall of 100 ms, then obedience.
  base::RunTime now = kEpoch + 200ms;
  int at_once = 0;
  int steps = 0;
  for (int i = 100; now > kEpoch + i * kStep; ++i, ++steps) {
    const base::RunTime start = pacer.start_of(at(i * kStep));
    if (start <= kEpoch + 200ms) ++at_once;
    if (steps > 20) {
      EXPECT_EQ(start - now, 800us) << "1.25 times the pace";
    }
    now = std::max(now, start);
    pacer.on_start(now, at(i * kStep));
  }
  EXPECT_LE(at_once, 13) << "10 ms of steps, 0.8 ms each";
  EXPECT_NEAR(steps, 450, 10) << "the rest of 100 ms at a quarter of extra pace";
  EXPECT_GT(pacer.late_steps(), 400u);
  EXPECT_EQ(pacer.given_up(), 0ns);
  EXPECT_EQ(pacer.lateness().max(), 100ms);
}

TEST(Pacer, LateWakeUpsDoNotSlowTheRun) {
  // Every sleep ends 3 ms late, as on a machine with more work than processors.
  Pacer pacer({}, kStep);
  pacer.restart(kEpoch, at(0s));
  base::RunTime now = kEpoch;
  for (int i = 0; i < 10'000; ++i) {
    const base::RunTime start = pacer.start_of(at(i * kStep));
    if (start > now) now = start + 3ms;
    pacer.on_start(now, at(i * kStep));
  }
  EXPECT_LE(now, kEpoch + 10s + 10ms);
}

TEST(Pacer, GivesUpWhatIsTooFarBehind) {
  Pacer pacer({.max_lag = 250ms}, kStep);
  pacer.restart(kEpoch, at(0s));
  pacer.on_start(kEpoch + 2s, at(0s));
  EXPECT_EQ(pacer.given_up(), 2s);
  EXPECT_EQ(pacer.start_of(at(kStep)), kEpoch + 2s + kStep);
}

TEST(Pacer, RestartForgetsAPause) {
  Pacer pacer({}, kStep);
  pacer.restart(kEpoch, at(0s));
  run(pacer, kEpoch, 0, 10);
  pacer.restart(kEpoch + 60s, at(10ms));
  EXPECT_EQ(pacer.start_of(at(10ms)), kEpoch + 60s);
  pacer.on_start(kEpoch + 60s, at(10ms));
  EXPECT_EQ(pacer.late_steps(), 0u);
}

TEST(Pacer, LockstepAndFreeRunDoNotWait) {
  for (const PaceMode mode : {PaceMode::kLockstep, PaceMode::kFreeRun}) {
    Pacer pacer({.mode = mode}, kStep);
    pacer.restart(kEpoch, at(0s));
    EXPECT_LT(pacer.start_of(at(1000s)), kEpoch);
    pacer.on_start(kEpoch, at(1000s));
    EXPECT_EQ(pacer.lateness().count(), 0u);
  }
}

TEST(Pacer, LockstepGoesByTheClockWhileAPeerDoesNotAnswerYet) {
  Pacer pacer({.mode = PaceMode::kLockstep}, kStep);
  pacer.set_peers_in_step(false, kEpoch, at(0s));
  EXPECT_EQ(pacer.start_of(at(100ms)), kEpoch + 100ms);
  pacer.set_peers_in_step(true, kEpoch + 100ms, at(100ms));
  EXPECT_LT(pacer.start_of(at(1000s)), kEpoch) << "at once from its first answer on";
  pacer.set_peers_in_step(false, kEpoch + 105ms, at(10s));
  EXPECT_EQ(pacer.start_of(at(10s)), kEpoch + 105ms) << "from here on, and nothing to catch up";
}

TEST(Pacer, LockstepKeepsToASpeedThatIsGiven) {
  Pacer pacer({.mode = PaceMode::kLockstep, .speed_given = true, .speed = 2.0}, kStep);
  pacer.restart(kEpoch, at(0s));
  EXPECT_EQ(pacer.start_of(at(100ms)), kEpoch + 50ms);
}

TEST(Pacer, TheBurstAfterALateWakeUpCanBeMadeSmaller) {
  Pacer pacer({.catch_up_rate = 1.0 / 0.9, .largest_burst = 1ms}, kStep);
  pacer.restart(kEpoch, at(0s));
  run(pacer, kEpoch, 0, 100);
  base::RunTime now = kEpoch + 108ms;  // 8 ms late
  pacer.on_start(now, at(100ms));
  const base::RunTime later = run(pacer, now, 101, 4);
  EXPECT_GE(later - now, 2500us) << "four steps and no burst";
}

TEST(Pacer, NoErrorAddsUpOverADay) {
  Pacer pacer({.speed = 3.0}, 333us);
  pacer.restart(kEpoch, at(0s));
  EXPECT_EQ(pacer.start_of(at(24h)) - kEpoch, 8h);
}

}  // namespace
}  // namespace cas::sim
