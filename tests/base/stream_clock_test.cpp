// SPDX-License-Identifier: BSD-3-Clause
#include "base/stream_clock.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace cas::base
