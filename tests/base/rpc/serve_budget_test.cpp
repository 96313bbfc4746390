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
constexpr double kShare = 0.1;

/// One thread that serves clients which ask again as soon as they may.
class BusyServer {
 public:
  explicit BusyServer(std::vector<Duration> costs)
      : costs_(std::move(costs)), next_(costs_.size(), kStart), waits_(costs_.size(), false) {
    lines.resize(costs_.size());
  }
  void run_until(RunTime end) {
    while (now_ < end) {
      const auto first = std::min_element(next_.begin(), next_.end()) - next_.begin();
      const auto i = static_cast<std::size_t>(first);
      if (waits_[i]) budget_.wait_ends();
      now_ = std::max(now_, next_[i]) + costs_[i];
      ++lines[i];
      const Duration wait = budget_.spend(costs_[i], now_);
      waits_[i] = wait > Duration::zero();
      if (waits_[i]) budget_.wait_begins();
      next_[i] = now_ + wait;
    }
  }
  /// Processor time of all lines.
  double used_s() const {
    double sum = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) sum += lines[i] * to_seconds(costs_[i]);
    return sum;
  }
  std::vector<int> lines;

 private:
  std::vector<Duration> costs_;
  std::vector<RunTime> next_;
  std::vector<bool> waits_;
  RunTime now_ = kStart;
  ServeBudget budget_{kShare, kStart};
};

TEST(ServeBudget, HoldsAllClientsTogetherToItsShare) {
  BusyServer server(std::vector<Duration>(20, microseconds(200)));
  server.run_until(kStart + seconds(10));
  // A tenth of ten seconds, and the burst of one second's share.
  EXPECT_NEAR(server.used_s(), 1.1, 0.15);
  const auto [least, most] = std::minmax_element(server.lines.begin(), server.lines.end());
  EXPECT_LE(*most - *least, *most / 4) << "equal turns";
}

TEST(ServeBudget, LetsNobodyPayForTheCostOfOthers) {
  std::vector<Duration> costs(20, milliseconds(40));
  costs[0] = microseconds(100);
  BusyServer server(costs);
  server.run_until(kStart + seconds(60));
  EXPECT_GT(server.lines[0], 60 * 25) << "a turn takes 20 times 100 us at a tenth: 20 ms";
  EXPECT_LT(server.lines[1], 60);
  EXPECT_LT(server.used_s(), 60 * 0.2);
}

TEST(ServeBudget, LetsThroughAtOnceWhoAsksNowAndThen) {
  ServeBudget budget(kShare, kStart);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(budget.spend(microseconds(500), kStart + i * milliseconds(10)), Duration::zero());
  }
}

TEST(ServeBudget, LetsNewClientsInWhenTheDebtIsEarnedOrAfterASecond) {
  ServeBudget budget(kShare, kStart);
  EXPECT_EQ(budget.before_next_client(kStart), Duration::zero());
  budget.spend(milliseconds(101), kStart);  // a second's share and a millisecond
  EXPECT_EQ(budget.before_next_client(kStart), milliseconds(10));
  EXPECT_EQ(budget.before_next_client(kStart + milliseconds(10)), Duration::zero());
  budget.spend(seconds(100), kStart + milliseconds(10));
  EXPECT_EQ(budget.before_next_client(kStart + milliseconds(10)), seconds(1));
}

TEST(ServeBudget, LetsNobodyWaitForEver) {
  ServeBudget budget(kShare, kStart);
  EXPECT_EQ(budget.spend(seconds(100), kStart), ServeBudget::kLongestTurn);
}

TEST(ServeBudget, WithAWholeProcessorNobodyWaits) {
  ServeBudget budget(1, kStart);
  EXPECT_EQ(budget.spend(seconds(100), kStart), Duration::zero());
  EXPECT_EQ(budget.before_next_client(kStart), Duration::zero());
}

}  // namespace
}  // namespace cas::base::rpc
