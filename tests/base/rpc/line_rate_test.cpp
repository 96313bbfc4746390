// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/line_rate.hpp"

#include <gtest/gtest.h>

namespace cas::base::rpc {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(LineRate, LetsASecondsWorthThroughAtOnceAndThenItsRate) {
  RunTime now{seconds(10)};
  LineRate rate(1000, now);
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(rate.take(now), Duration::zero()) << i;
  int lines = 0;
  for (const RunTime end = now + seconds(2); now < end; ++lines) now += rate.take(now);
  EXPECT_NEAR(lines, 2000, 2);
}

TEST(LineRate, SavesUpASecondsWorthAtMost) {
  RunTime now{seconds(10)};
  LineRate rate(100, now);
  now += seconds(3600);
  int at_once = 0;
  while (rate.take(now) == Duration::zero()) ++at_once;
  EXPECT_EQ(at_once, 100);
  EXPECT_EQ(LineRate(100, now).take(now), Duration::zero());
}

TEST(LineRate, TellsHowLongToWait) {
  const RunTime now{seconds(10)};
  LineRate rate(1, now);
  EXPECT_EQ(rate.take(now), Duration::zero());
  EXPECT_EQ(rate.take(now), seconds(1));
  EXPECT_EQ(rate.take(now + milliseconds(1500)), milliseconds(500));
}

}  // namespace
}  // namespace cas::base::rpc
