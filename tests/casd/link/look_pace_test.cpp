// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/link_loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

/// A thread that finds a steady stream.
class Looker {
 public:
  /// @return looks in `time` at `packets_s`, each as late as packet or pace demand
  int watch(base::Duration time, double packets_s) {
    int looks = 0;
    const base::RunTime begin = now_;
    const auto packet = [&](int number) { return begin + base::from_seconds(number / packets_s); };
    const int last = static_cast<int>(base::to_seconds(time) * packets_s);
    for (int next = 1; next <= last;) {
      now_ = std::max(packet(next), pace_.next_look());
      for (; next <= last && packet(next) <= now_; ++next) ++received_;
      pace_.looked(now_, received_);
      ++looks;
    }
    return looks;
  }

 private:
  LookPace pace_;
  base::RunTime now_ = at(std::chrono::seconds(1));
  std::uint64_t received_ = 0;
};

TEST(LookPace, LooksAtEachPacketOfAControlLoop) {
  Looker looker;
  EXPECT_NEAR(looker.watch(std::chrono::seconds(1), 905), 905, 2);
}

TEST(LookPace, LooksAtEachPacketBelowTheBound) {
  Looker looker;
  EXPECT_NEAR(looker.watch(std::chrono::seconds(1), 45'000), 45'000, 10);
}

TEST(LookPace, RestsBetweenTwoLooksInAFlood) {
  Looker looker;
  // The first millisecond of the flood goes by unmoderated.
  EXPECT_NEAR(looker.watch(std::chrono::seconds(1), 200'000), 1.0 / 150e-6 + 200, 100);
}

TEST(LookPace, LooksAtEachPacketAgainAfterAFlood) {
  Looker looker;
  looker.watch(std::chrono::seconds(1), 200'000);
  EXPECT_NEAR(looker.watch(std::chrono::seconds(1), 45'000), 45'000, 100);
}

TEST(LookPace, TakesWhatComesAfterALongSilenceForNoFlood) {
  LookPace pace;
  pace.looked(at(std::chrono::seconds(10)), 64);
  EXPECT_EQ(pace.next_look(), at(std::chrono::seconds(10)));
}

}  // namespace
}  // namespace cas::casd::test
