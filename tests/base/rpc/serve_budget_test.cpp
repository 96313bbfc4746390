// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/serve_budget.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace cas::base::rpc {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr RunTime kStart{seconds(10)};

TEST(ServeBudget, HoldsAllClientsTogetherToItsShare) {
  constexpr int kClients = 20;
  constexpr Duration kCost = microseconds(200);
  ServeBudget budget(0.1, kStart);
  std::vector<RunTime> next(kClients, kStart);
  std::vector<int> lines(kClients, 0);
  const RunTime end = kStart + seconds(10);
  RunTime now = kStart;  // one thread serves them one after the other
  while (now < end) {
    const auto first = std::min_element(next.begin(), next.end());
    now = std::max(now, *first) + kCost;
    ++lines[static_cast<std::size_t>(first - next.begin())];
    *first = now + budget.spend(kCost, now);
  }
  int all = 0;
  for (const int each : lines) all += each;
  // A tenth of ten seconds, and what was saved up for a second.
  EXPECT_NEAR(all * to_seconds(kCost), 1.1, 0.02);
  const auto [least, most] = std::minmax_element(lines.begin(), lines.end());
  EXPECT_LE(*most - *least, *most / 5) << "equal turns";
}

TEST(ServeBudget, LetsThroughAtOnceWhoAsksNowAndThen) {
  ServeBudget budget(0.1, kStart);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(budget.spend(microseconds(500), kStart + i * milliseconds(10)), Duration::zero());
  }
}

TEST(ServeBudget, SavesUpASecondsShareAtMost) {
  ServeBudget budget(0.1, kStart);
  const RunTime late = kStart + seconds(3600);
  EXPECT_EQ(budget.spend(milliseconds(100), late), Duration::zero());
  EXPECT_EQ(budget.spend(milliseconds(1), late), milliseconds(10));
}

TEST(ServeBudget, WithAWholeProcessorNobodyWaits) {
  ServeBudget budget(1, kStart);
  EXPECT_EQ(budget.spend(seconds(100), kStart), Duration::zero());
}

}  // namespace
}  // namespace cas::base::rpc
