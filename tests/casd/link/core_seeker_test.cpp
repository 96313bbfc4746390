// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/core_seeker.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <utility>
#include <vector>

namespace cas::casd::test {
namespace {

using namespace std::chrono_literals;  // NOLINT: durations of a table
using base::Duration;

constexpr int kAny = -1;

/// A thread whose cost per packet depends on its core.
class Bench {
 public:
  explicit Bench(std::vector<int> cores = {0, 1}) : seeker(std::move(cores)) {}

  int core() const { return seeker.core().value_or(kAny); }

  /// Lets time pass, sample by sample.
  void run(Duration time) {
    for (const base::RunTime end = now + time; now < end;) {
      const std::uint64_t turns = seeker.sample_turns();
      const auto count = static_cast<std::int64_t>(turns);
      const Duration elapsed = base::from_seconds(static_cast<double>(turns) / rate_hz);
      now += elapsed;
      ++visits[core()];
      spent[core()] += elapsed;
      seeker.take({.turns = turns,
                   .elapsed = elapsed,
                   .ran = count * ran[core()],
                   .queued = count * queued[core()],
                   .stamped = arrival.empty() ? 0 : turns,
                   .arrival = count * arrival[core()]},
                  now);
    }
  }

  CoreSeeker seeker;
  double rate_hz = 500;
  base::RunTime now{10s};
  std::map<int, Duration> ran{{kAny, 30us}, {0, 30us}, {1, 6us}};
  std::map<int, Duration> queued{{kAny, 3us}, {0, 3us}, {1, 3us}};
  std::map<int, Duration> arrival;
  std::map<int, int> visits;      ///< samples by core
  std::map<int, Duration> spent;  ///< time by core
};

TEST(CoreSeeker, SettlesWhereAPacketCostsLeast) {
  Bench bench;
  bench.run(500ms);
  EXPECT_TRUE(bench.seeker.settled());
  EXPECT_EQ(bench.core(), 1);
  EXPECT_EQ(bench.seeker.cost(), 9us);
  EXPECT_EQ(bench.seeker.free_cost(), 33us);
}

TEST(CoreSeeker, CountsTheTimeFromTheKernelsStampToTheRead) {
  Bench bench;
  bench.arrival = {{kAny, 45us}, {0, 5us}, {1, 45us}};
  bench.run(500ms);
  EXPECT_EQ(bench.core(), 0);  // 30 + 5 us against 6 + 45 us
}

TEST(CoreSeeker, LeavesTheChoiceToTheSchedulerWhereNoCoreIsClearlyCheaper) {
  Bench bench;
  bench.ran = {{kAny, 10us}, {0, 11us}, {1, 9us}};
  bench.run(600s);
  EXPECT_EQ(bench.core(), kAny);
  // Trials become rare: of ten minutes they take less than a hundredth.
  EXPECT_GT(bench.visits[0], 0);
  EXPECT_LT(100 * (bench.spent[0] + bench.spent[1]), bench.spent[kAny]);
}

// Each look costs a system call.
TEST(CoreSeeker, LooksSeldomWhereThereIsNothingToTry) {
  Bench slow;
  slow.rate_hz = 50;
  slow.run(60s);
  EXPECT_EQ(slow.core(), kAny);
  EXPECT_EQ(slow.seeker.sample_turns(), 128U);
  Bench even;
  even.ran = {{kAny, 10us}, {0, 11us}, {1, 9us}};
  even.run(60s);
  EXPECT_EQ(even.seeker.sample_turns(), 128U);
}

/// The cheap core is the other one from now on.
void move_peer(Bench& bench) { std::swap(bench.ran[0], bench.ran[1]); }

TEST(CoreSeeker, FollowsWhoHasMoved) {
  Bench bench;
  bench.run(1s);
  ASSERT_EQ(bench.core(), 1);
  bench.visits.clear();
  move_peer(bench);
  // A sample of 128 turns and two of 32, then 40 on the other core, at 500 Hz.
  bench.run(464ms);
  EXPECT_EQ(bench.core(), 0);
  EXPECT_TRUE(bench.seeker.settled());
  EXPECT_EQ(bench.visits[kAny], 0);
}

TEST(CoreSeeker, IsWithWhoMovesEveryTwoSecondsMostOfTheTime) {
  Bench bench;
  bench.run(1s);
  Duration cheap{};
  for (int move = 0; move < 60; ++move) {
    move_peer(bench);
    bench.spent.clear();
    bench.run(2s);
    cheap += bench.ran[0] < bench.ran[1] ? bench.spent[0] : bench.spent[1];
  }
  EXPECT_GT(cheap, 90s);  // of two minutes
}

TEST(CoreSeeker, DoesNotRunAfterWhoMovesAllTheTime) {
  for (const double rate_hz : {200.0, 500.0, 1000.0, 2000.0}) {
    Bench bench;
    bench.rate_hz = rate_hz;
    const Duration between = base::from_seconds(200 / rate_hz);  // as soon as it has settled
    bench.run(5s);
    for (int move = 0; move < 1200; ++move) {
      move_peer(bench);
      bench.run(between);
      if (move == 600) bench.spent.clear();
    }
    EXPECT_GT(bench.spent[kAny], 2 * (bench.spent[0] + bench.spent[1])) << rate_hz;
  }
}

// A trial while the peer moves measures a mixture: settled on it, nothing would cost twice as much.
TEST(CoreSeeker, DoesNotStayWhereAPacketCostsAsMuchAsWithoutAChoice) {
  Bench bench;
  bench.ran[1] = 15us;  // with the queue 18 us: twice as much and the noise are 41 us
  bench.run(1s);
  ASSERT_EQ(bench.core(), 1);
  bench.ran = {{kAny, 30us}, {0, 6us}, {1, 30us}};
  bench.run(3s);
  EXPECT_EQ(bench.core(), 0);
}

TEST(CoreSeeker, TriesAgainSoonAfterAChoiceThatHasLasted) {
  Bench bench;
  const auto cheap = bench.ran;
  bench.ran = {{kAny, 10us}, {0, 10us}, {1, 10us}};
  bench.run(600s);  // trials fail, and the pause grows to 128 s
  bench.ran = cheap;
  bench.run(200s);
  ASSERT_EQ(bench.core(), 1);
  bench.seeker.release(bench.now);
  bench.run(1s);
  EXPECT_EQ(bench.core(), 1);
}

TEST(CoreSeeker, AMoveToNoCheapCoreLeavesTheChoiceToTheScheduler) {
  Bench bench;
  bench.run(1s);
  ASSERT_EQ(bench.core(), 1);
  bench.ran[1] = 30us;
  bench.run(1s);
  EXPECT_FALSE(bench.seeker.settled());
}

TEST(CoreSeeker, OneDearSampleIsNoReason) {
  Bench bench;
  bench.run(1s);
  ASSERT_EQ(bench.core(), 1);
  bench.ran[1] = 200us;
  bench.run(1ms);  // one sample
  bench.ran[1] = 6us;
  bench.run(1s);
  EXPECT_EQ(bench.core(), 1);
  EXPECT_EQ(bench.visits[0], 2);  // of the first trial
}

TEST(CoreSeeker, YieldsABusyCoreWithinASample) {
  Bench bench;
  bench.run(1s);
  ASSERT_EQ(bench.core(), 1);
  bench.queued = {{kAny, 3us}, {0, 3us}, {1, 2ms}};
  bench.run(1ms);
  EXPECT_EQ(bench.core(), kAny);
  // It looks now and then, ever more seldom.
  bench.spent.clear();
  bench.run(120s);
  EXPECT_LT(100 * bench.spent[1], bench.spent[kAny] + bench.spent[0]);
}

TEST(CoreSeeker, YieldsAtOnceInAFlood) {
  Bench bench;
  bench.run(1s);
  ASSERT_EQ(bench.core(), 1);
  bench.seeker.release(bench.now);
  EXPECT_EQ(bench.core(), kAny);
}

TEST(CoreSeeker, StaysFreeOutsideItsRates) {
  for (const double rate_hz : {20.0, 99.0, 5001.0, 50'000.0}) {
    Bench bench;
    bench.rate_hz = rate_hz;
    bench.run(60s);
    EXPECT_EQ(bench.visits.size(), 1U) << rate_hz;
    EXPECT_EQ(bench.core(), kAny) << rate_hz;
  }
}

TEST(CoreSeeker, StaysFreeWhereItNeedsACoreOfItsOwn) {
  Bench bench;
  bench.ran = {{kAny, 700us}, {0, 700us}, {1, 100us}};  // 35 % of a core at 500 Hz
  bench.run(60s);
  EXPECT_EQ(bench.visits.size(), 1U);
}

TEST(CoreSeeker, OneCoreLeavesNothingToSeek) {
  Bench bench({3});
  EXPECT_FALSE(bench.seeker.seeks());
  bench.run(10s);
  EXPECT_EQ(bench.core(), kAny);
}

TEST(CoreSeeker, TriesAtMostSixteenCores) {
  std::vector<int> cores(64);
  for (int core = 0; core < 64; ++core) cores[static_cast<std::size_t>(core)] = core;
  Bench bench(cores);
  bench.run(10s);
  EXPECT_EQ(bench.visits.size(), CoreSeeker::kMostCores + 1);
}

}  // namespace
}  // namespace cas::casd::test
