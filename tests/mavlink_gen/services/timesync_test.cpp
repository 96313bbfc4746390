// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/timesync.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace cas::mav::services {
namespace {

using namespace std::chrono_literals;
using mavlink::common::Ping;
using mavlink::common::Timesync;

constexpr Source kStation{255, 190};

TEST(Timesync, AnAnswerCarriesTheQuestionsTimeAndIsNotAnsweredAgain) {
  const auto reply = answer(Timesync{.ts1 = 42}, kStation, 5s);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->ts1, 42);
  EXPECT_EQ(reply->tc1, 5'000'000'000);
  EXPECT_EQ(reply->target_system, 255);
  EXPECT_FALSE(answer(*reply, kStation, 6s));
}

TEST(Timesync, APingComesBackToItsSender) {
  const auto reply = answer(Ping{7, 3, 0, 0}, kStation);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->seq, 3U);
  EXPECT_EQ(reply->target_component, 190);
  EXPECT_FALSE(answer(*reply, kStation));
}

/// A question whose answer takes `there` and `back`; their clock is an hour ahead.
bool ask(ClockEstimate& estimate, Time now, Duration there, Duration back) {
  const auto reply = answer(estimate.ask(now), kStation, (now + there).time_since_epoch() + 1h);
  return reply && estimate.on_timesync(*reply, now + there + back);
}

TEST(ClockEstimate, GoesByTheQuickestAnswer) {
  ClockEstimate estimate;
  EXPECT_FALSE(estimate.offset());
  EXPECT_TRUE(ask(estimate, Time(10s), 80ms, 2ms));
  EXPECT_EQ(estimate.offset(), 1h + 39ms) << "a way there that is longer looks like an offset";
  EXPECT_TRUE(ask(estimate, Time(11s), 3ms, 3ms));
  EXPECT_TRUE(ask(estimate, Time(12s), 2ms, 80ms));
  EXPECT_EQ(estimate.offset(), 1h);
  EXPECT_EQ(estimate.round_trip(), 6ms);
}

TEST(ClockEstimate, ForgetsAnAnswerAfterEightMore) {
  ClockEstimate estimate;
  ask(estimate, Time(10s), 1ms, 1ms);
  for (int i = 0; i < 8; ++i) ask(estimate, Time(11s), 20ms, 20ms);
  EXPECT_EQ(estimate.round_trip(), 40ms);
}

TEST(ClockEstimate, LeavesOutQuestionsAndAnswersToOthers) {
  ClockEstimate estimate;
  EXPECT_FALSE(estimate.on_timesync(estimate.ask(Time(1s)), Time(1s)));
  Timesync to_another{.tc1 = 1};
  to_another.ts1 = 99'000'000'000;  // from the future
  EXPECT_FALSE(estimate.on_timesync(to_another, Time(1s)));
  EXPECT_FALSE(estimate.offset());
}

TEST(ClockEstimate, LeavesOutNumbersThatNoClockShows) {
  constexpr auto kLeast = std::numeric_limits<std::int64_t>::min();
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  ClockEstimate estimate;
  Timesync message;
  for (const std::int64_t number : {kLeast, kLeast + 1, kMost - 1, kMost}) {
    for (const Time now : {Time(0s), Time(1s), Time(std::chrono::years(60))}) {
      message.tc1 = 1;
      message.ts1 = number;
      EXPECT_FALSE(estimate.on_timesync(message, now)) << number;
      message.tc1 = number;
      message.ts1 = (now - 1ms).time_since_epoch().count();
      EXPECT_FALSE(estimate.on_timesync(message, now)) << number;
    }
  }
  EXPECT_FALSE(estimate.offset());
}

}  // namespace
}  // namespace cas::mav::services
