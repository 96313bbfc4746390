// SPDX-License-Identifier: BSD-3-Clause
#include "base/time/stream_clock.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace cas::base {
namespace {

using std::chrono::milliseconds;

TEST(StreamClock, ShowsTheStampOfTheNewestSensor) {
  StreamClock clock;
  EXPECT_EQ(clock.now(), RunTime{});
  clock.on_sensor(2'000);
  clock.on_sensor(4'000);
  EXPECT_EQ(clock.now(), RunTime(milliseconds(4)));
}

TEST(StreamClock, StaysWhenMessagesOfSeveralVehiclesOvertake) {
  StreamClock clock;
  clock.on_sensor(10'000);
  clock.on_sensor(8'000);
  EXPECT_EQ(clock.now(), RunTime(milliseconds(10)));
}

TEST(StreamClock, GoesOnWhenTheSimulationStartsAnew) {
  StreamClock clock;
  clock.on_sensor(5'000'000);
  clock.on_sensor(2'000);
  EXPECT_EQ(clock.now(), RunTime(milliseconds(5'002)));
}

TEST(StreamClock, LeavesOutAStampThatIsDamage) {
  StreamClock clock;
  clock.on_sensor(4'000);
  clock.on_sensor(std::uint64_t{1} << 63U);
  clock.on_sensor(6'000);
  EXPECT_EQ(clock.now(), RunTime(milliseconds(6)));
}

struct Epoch {
  const char* name;
  std::uint64_t first;
};

class StreamClockEpoch : public testing::TestWithParam<Epoch> {};

TEST_P(StreamClockEpoch, RunsAsFastAsItsStamps) {
  StreamClock clock;
  const std::uint64_t first = GetParam().first;
  clock.on_sensor(first);
  clock.on_sensor(first + 2'000);
  const RunTime begin = clock.now();
  EXPECT_GE(begin, RunTime{});
  EXPECT_LE(begin, RunTime(milliseconds(1'002)));
  clock.on_sensor(first + 4'000);
  EXPECT_EQ(clock.now() - begin, milliseconds(2));
}

TEST_P(StreamClockEpoch, GoesOnAfterAnyNumberOfRuns) {
  StreamClock clock;
  RunTime before;
  for (int run = 0; run < 100; ++run) {
    clock.on_sensor(GetParam().first);
    clock.on_sensor(GetParam().first + 2'000);
    EXPECT_GT(clock.now(), before);
    EXPECT_LE(clock.now() - before, milliseconds(1'004));
    before = clock.now();
    clock.on_sensor(2'000);  // a run whose stamps begin at zero
  }
}

INSTANTIATE_TEST_SUITE_P(All, StreamClockEpoch,
                         testing::Values(Epoch{"Microseconds", 1'755'000'000'000'000},
                                         Epoch{"Nanoseconds", 1'755'000'000'000'000'000},
                                         Epoch{"Largest",
                                               std::numeric_limits<std::uint64_t>::max() - 4'000}),
                         [](const auto& test) { return test.param.name; });

TEST(StreamClock, StopsBeforeItOverflows) {
  StreamClock clock;
  RunTime before;
  for (std::uint64_t time_usec = 0, i = 0; i < 3'000'000; ++i, time_usec += 3'500'000'000) {
    clock.on_sensor(time_usec);
    ASSERT_GE(clock.now(), before);
    before = clock.now();
  }
  EXPECT_EQ(before, RunTime(std::chrono::microseconds(kLatestTimeUsec)));
}

}  // namespace
}  // namespace cas::base
