// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/snapshot_flow.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace cas::web {
namespace {

using base::RunTime;
using std::chrono::milliseconds;

TEST(SnapshotFlow, SendsNothingUntilTheLastOneIsAcknowledged) {
  SnapshotFlow flow(10);
  RunTime now{};
  ASSERT_TRUE(flow.wants(now));
  flow.on_sent(7, now);
  now += std::chrono::hours(1);
  EXPECT_FALSE(flow.wants(now));
  EXPECT_FALSE(flow.waits());
  EXPECT_FALSE(flow.on_ack(6));  // of one that is long gone
  EXPECT_FALSE(flow.wants(now));
  EXPECT_TRUE(flow.on_ack(7));
  EXPECT_TRUE(flow.wants(now));
}

TEST(SnapshotFlow, AnotherRateKeepsWhatIsInFlight) {
  SnapshotFlow flow(10);
  flow.on_sent(7, RunTime{});
  flow.set_rate(20);
  EXPECT_FALSE(flow.wants(RunTime{} + std::chrono::hours(1)));
  EXPECT_TRUE(flow.on_ack(7));
  EXPECT_TRUE(flow.wants(RunTime{} + std::chrono::hours(1)));
}

TEST(SnapshotFlow, KeepsItsRateThoughTimersJitter) {
  SnapshotFlow flow(50);
  int sent = 0;
  // Looked at every 20 ms, by turns 3 ms early and late.
  for (int i = 0; i < 100; ++i) {
    const RunTime now = RunTime{} + milliseconds(20 * i + (i % 2 == 0 ? 3 : 0));
    if (!flow.wants(now)) continue;
    flow.on_sent(static_cast<std::uint64_t>(++sent), now);
    flow.on_ack(static_cast<std::uint64_t>(sent));
  }
  EXPECT_EQ(sent, 100);
}

TEST(SnapshotFlow, GivesASlowerRateThanIsOffered) {
  SnapshotFlow flow(2);
  int sent = 0;
  for (int i = 0; i < 600; ++i) {  // 10 s of 60 Hz
    const RunTime now = RunTime{} + std::chrono::microseconds(16'667 * i);
    if (!flow.wants(now)) continue;
    flow.on_sent(static_cast<std::uint64_t>(++sent), now);
    flow.on_ack(static_cast<std::uint64_t>(sent));
  }
  EXPECT_EQ(sent, 20);
}

}  // namespace
}  // namespace cas::web
