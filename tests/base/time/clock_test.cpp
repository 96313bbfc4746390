// SPDX-License-Identifier: BSD-3-Clause
#include "base/time/clock.hpp"

#include <gtest/gtest.h>

namespace cas::base {
namespace {

using namespace std::chrono_literals;

TEST(Clock, SteadyNowNeverGoesBack) {
  const RunTime first = steady_now();
  EXPECT_GE(steady_now(), first);
}

TEST(Clock, SecondsRoundToTheNearestNanosecond) {
  EXPECT_EQ(from_seconds(0.0025), 2'500'000ns);
  EXPECT_EQ(from_seconds(-0.0025), -2'500'000ns);
  EXPECT_EQ(from_seconds(1e-9 * 0.6), 1ns);
  EXPECT_EQ(from_seconds(1e-9 * 0.4), 0ns);
}

TEST(Clock, SecondsSurviveTheRoundTrip) {
  EXPECT_DOUBLE_EQ(to_seconds(from_seconds(12.345)), 12.345);
  EXPECT_DOUBLE_EQ(to_seconds(SimTime(1500ms)), 1.5);
}

TEST(Clock, WireMicrosecondsSurviveTheRoundTrip) {
  EXPECT_EQ(to_time_usec(SimTime(2ms)), 2000U);
  EXPECT_EQ(from_time_usec(2000), SimTime(2ms));
  EXPECT_EQ(to_time_usec(from_time_usec(1'755'000'000'000'000)), 1'755'000'000'000'000U);
}

TEST(Clock, DamagedStampsStayWithinTheLatestOne) {
  constexpr SimTime kLatest = from_time_usec(kLatestTimeUsec);
  EXPECT_EQ(from_time_usec(~std::uint64_t{0}), kLatest);
  EXPECT_EQ(from_time_usec(std::uint64_t{1} << 63U), kLatest);
  EXPECT_EQ(from_time_usec(9'223'372'036'854'775'808U / 1000 + 1), kLatest);  // would be negative
}

}  // namespace
}  // namespace cas::base
