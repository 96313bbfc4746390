// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/link_loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/casd/packets.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::casd::test {
namespace {

using cas::test::wait_until;

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
  // The first millisecond of the flood is not moderated.
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

TEST(LookPace, TellsAFloodFromABurst) {
  using std::chrono::microseconds;
  LookPace pace;
  std::uint64_t received = 0;
  base::RunTime now = at(std::chrono::seconds(1));
  const auto look = [&](std::uint64_t packets) {
    now += microseconds(150);
    received += packets;
    pace.looked(now, received);
  };
  for (int i = 0; i < 60; ++i) look(30);
  EXPECT_TRUE(pace.busy());
  EXPECT_FALSE(pace.flood_lasts(now)) << "9 ms";
  for (int i = 0; i < 20; ++i) look(30);
  EXPECT_TRUE(pace.flood_lasts(now));
  for (int i = 0; i < 20; ++i) look(1);
  EXPECT_FALSE(pace.flood_lasts(now));
  EXPECT_FALSE(pace.flood_is_over(now)) << "it may go on";
  EXPECT_TRUE(pace.flood_is_over(now + LookPace::kCalm));
}

TEST(LookPace, TakesALinkThatComesForNoFlood) {
  LookPace pace;
  const base::RunTime begin = at(std::chrono::seconds(1));
  pace.looked(begin, 0);
  pace.add_link(1'000'000);
  pace.looked(begin + std::chrono::milliseconds(2), 1'000'001);
  EXPECT_FALSE(pace.busy());
}

class CountingLink final : public Link {
 public:
  /// @param closed  while true it watches a descriptor that is not open
  CountingLink(std::atomic<int>& turns, std::atomic<bool>& closed)
      : turns_(turns), closed_(closed) {}
  void watch(PollSet& set, base::RunTime) override {
    ++turns_;
    constexpr int kNotOpen = 1'000'000;
    set.add(closed_ ? OpenDescriptor(kNotOpen) : OpenDescriptor(), POLLIN);
  }
  void serve(const PollSet&, base::RunTime) override {}
  std::uint64_t received() const override { return 0; }
  std::shared_ptr<PacketPort> port() override { return nullptr; }

 private:
  std::atomic<int>& turns_;
  std::atomic<bool>& closed_;
};

TEST(LinkLoop, PausesAndSaysItOnceWhenItCannotWait) {
  testing::internal::CaptureStderr();
  std::atomic<int> turns{0};
  std::atomic<bool> closed{false};
  LinkLoop loop("fixture", {});
  loop.add(std::make_unique<CountingLink>(turns, closed));
  loop.start();
  ASSERT_TRUE(wait_until([&] { return turns > 0; }));
  closed = true;
  loop.wake();  // it still waits from before
  const base::RunTime begin = base::steady_now();
  const int before = turns;
  EXPECT_TRUE(wait_until([&] { return turns >= before + 5; }));
  EXPECT_GE(base::steady_now() - begin, std::chrono::milliseconds(290)) << "it spins";
  closed = false;
  int ran = 0;
  loop.run_on_loop([&] { ++ran; });
  EXPECT_EQ(ran, 1) << "it goes on once it can wait again";
  loop.stop();
  const std::string said = testing::internal::GetCapturedStderr();
  const std::size_t first = said.find("cannot wait for their descriptors");
  ASSERT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find("cannot wait", first + 1), std::string::npos) << said;
}

}  // namespace
}  // namespace cas::casd::test
