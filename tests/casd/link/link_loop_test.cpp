// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/link_loop.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <new>
#include <vector>

#include "tests/casd/packets.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::casd::test {
namespace {

using cas::test::wait_until;

/// A thread that finds a steady stream.
class Looker {
 public:
  /// @param cost  what the thread needs for a packet
  explicit Looker(base::Duration cost = {}) : cost_(cost) {}

  /// @return looks in `time` at `packets_s`, each as late as packet or pace demand
  int watch(base::Duration time, double packets_s) {
    int looks = 0;
    const base::RunTime begin = now_;
    const auto packet = [&](int number) { return begin + base::from_seconds(number / packets_s); };
    const int last = static_cast<int>(base::to_seconds(time) * packets_s);
    for (int next = 1; next <= last;) {
      now_ = std::max(now_, pace_.next_look());
      idle_ += std::max(packet(next) - now_, base::Duration{});
      now_ = std::max(packet(next), now_);
      const std::uint64_t before = received_;
      for (; next <= last && packet(next) <= now_; ++next) ++received_;
      now_ += (received_ - before) * cost_;
      pace_.looked(now_, received_, idle_);
      ++looks;
    }
    return looks;
  }
  const LookPace& pace() const { return pace_; }
  base::RunTime now() const { return now_; }

 private:
  LookPace pace_;
  base::RunTime now_ = at(std::chrono::seconds(1));
  std::uint64_t received_ = 0;
  base::Duration idle_{};
  base::Duration cost_;
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
  pace.looked(at(std::chrono::seconds(10)), 64, {});
  EXPECT_EQ(pace.next_look(), at(std::chrono::seconds(10)));
}

TEST(LookPace, TellsAFloodFromABurst) {
  Looker looker;
  looker.watch(std::chrono::milliseconds(10), 200'000);
  EXPECT_TRUE(looker.pace().busy());
  for (int i = 0; i < 100; ++i) {
    looker.watch(std::chrono::milliseconds(1), 4'000);
    EXPECT_FALSE(looker.pace().flood_lasts()) << i;
  }
  EXPECT_FALSE(looker.pace().busy());
}

TEST(LookPace, SeesTheFloodOfABusyMachineThroughItsGaps) {
  Looker looker;
  for (int i = 0; i < 30; ++i) {
    looker.watch(std::chrono::milliseconds(1), 400'000);
    looker.watch(std::chrono::milliseconds(3), 1'000);
    EXPECT_FALSE(looker.pace().busy());
  }
  EXPECT_TRUE(looker.pace().flood_lasts());
  EXPECT_FALSE(looker.pace().flood_is_over(looker.now()));
  looker.watch(std::chrono::milliseconds(100), 1'000);
  EXPECT_FALSE(looker.pace().flood_lasts());
  EXPECT_FALSE(looker.pace().flood_is_over(looker.now())) << "it may go on";
  EXPECT_TRUE(looker.pace().flood_is_over(looker.now() + LookPace::kCalm));
}

TEST(LookPace, SeesAFloodInWhatLeavesAThreadNoRest) {
  for (const auto cost : {std::chrono::microseconds(10), std::chrono::microseconds(40)}) {
    Looker looker(cost);
    looker.watch(std::chrono::milliseconds(200), 30'000);
    EXPECT_EQ(looker.pace().flood_lasts(), cost == std::chrono::microseconds(40));
  }
  LookPace relieved;  // by a thread of its own, on which the same packets leave it rest
  const auto look = [&](int ms, std::uint64_t received, base::Duration idle) {
    relieved.looked(at(std::chrono::seconds(1)) + std::chrono::milliseconds(ms), received, idle);
  };
  for (int ms = 0; ms < 6000; ++ms) look(ms, 30U * static_cast<unsigned>(ms), {});
  EXPECT_TRUE(relieved.flood_lasts());
  for (int ms = 6000; ms < 12'000; ++ms) {
    look(ms, 30U * static_cast<unsigned>(ms), std::chrono::milliseconds(ms - 6000) / 2);
  }
  EXPECT_FALSE(relieved.flood_lasts());
  EXPECT_FALSE(relieved.flood_is_over(at(std::chrono::seconds(13)))) << "they go on";
  Looker slow(std::chrono::milliseconds(1));  // a machine that is too slow for a HIL loop
  slow.watch(std::chrono::milliseconds(200), 905);
  EXPECT_FALSE(slow.pace().flood_lasts());
}

TEST(LookPace, TakesALinkThatComesForNoFlood) {
  LookPace pace;
  const base::RunTime begin = at(std::chrono::seconds(1));
  pace.looked(begin, 0, {});
  pace.add_link(1'000'000);
  pace.looked(begin + std::chrono::milliseconds(2), 1'000'001, {});
  EXPECT_FALSE(pace.busy());
  pace.looked(begin + std::chrono::milliseconds(102), 1'000'100, {});
  EXPECT_FALSE(pace.flood_lasts());
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

/// Gets no memory in its first turns.
class LackingLink final : public Link {
 public:
  explicit LackingLink(std::atomic<int>& turns) : turns_(turns) {}
  void watch(PollSet& set, base::RunTime now) override {
    set.wake_by(now + std::chrono::milliseconds(1));
  }
  void serve(const PollSet&, base::RunTime) override {
    if (++turns_ <= 3) throw std::bad_alloc();
  }
  std::uint64_t received() const override { return 0; }
  std::shared_ptr<PacketPort> port() override { return nullptr; }

 private:
  std::atomic<int>& turns_;
};

TEST(LinkLoop, LackOfMemoryCostsALinkItsTurnAndNoOther) {
  testing::internal::CaptureStderr();
  std::atomic<int> lacking{0};
  std::atomic<int> turns{0};
  std::atomic<bool> closed{false};
  LinkLoop loop("fixture", {});
  loop.add(std::make_unique<LackingLink>(lacking));
  loop.add(std::make_unique<CountingLink>(turns, closed));
  loop.start();
  EXPECT_TRUE(wait_until([&] { return lacking > 5 && turns > 5; }));
  loop.stop();
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("fixture: no memory"), std::string::npos) << said;
}

/// A link that works in watch() or in serve().
class BusyLink final : public Link {
 public:
  BusyLink(std::function<void()> watching, std::function<void()> serving)
      : watching_(std::move(watching)), serving_(std::move(serving)) {}
  void watch(PollSet& set, base::RunTime now) override {
    set.wake_by(now + std::chrono::milliseconds(1));
    watching_();
  }
  void serve(const PollSet&, base::RunTime) override { serving_(); }
  std::uint64_t received() const override { return 0; }
  std::shared_ptr<PacketPort> port() override { return nullptr; }

 private:
  std::function<void()> watching_;
  std::function<void()> serving_;
};

void compute(base::Duration processor) {
  const auto used = [] {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
  };
  const auto end = used() + processor;
  while (used() < end) {
  }
}

void sleep_often() {
  for (int i = 0; i < 200; ++i) ::poll(nullptr, 0, 1);
}

void read_much() {
  const base::Descriptor zero(::open("/dev/zero", O_RDONLY | O_CLOEXEC));
  std::vector<char> bytes(std::size_t{1} << 20U);
  if (::read(zero.get(), bytes.data(), bytes.size()) <= 0) std::exit(1);
}

enum class At : std::uint8_t { kTask, kWatch, kServe };

/// Runs a metered loop that does the work once (kTask) or in each turn, for ten turns.
void turn_with(At at, const std::function<void()>& work) {
  std::atomic<int> turns{0};
  const auto none = [] {};
  LinkLoop loop("fixture", {});
  loop.meter_turns();
  loop.add(std::make_unique<BusyLink>(at == At::kWatch ? work : none, [&] {
    ++turns;
    if (at == At::kServe) work();
  }));
  loop.start();
  if (at == At::kTask) loop.run_on_loop(work);
  wait_until([&] { return turns >= 10; });
  loop.stop();
}

struct TurnCase {
  const char* name;
  At at;
  void (*work)();
  const char* says;
};

class MeteredTurn : public testing::TestWithParam<TurnCase> {
 protected:
  void SetUp() override { testing::FLAGS_gtest_death_test_style = "threadsafe"; }
};

TEST_P(MeteredTurn, AbortsWhenItTakesTooMuch) {
  const auto& [name, at, work, says] = GetParam();
  if (work == read_much && ::access("/proc/thread-self/io", R_OK) != 0) {
    GTEST_SKIP() << "this kernel counts no bytes";
  }
  EXPECT_DEATH(turn_with(at, work), says);
}

constexpr auto kTooLong = [] { compute(std::chrono::milliseconds(250)); };

INSTANTIATE_TEST_SUITE_P(
    Turns, MeteredTurn,
    testing::Values(TurnCase{"TaskThatComputes", At::kTask, kTooLong, "one turn took"},
                    TurnCase{"TaskThatWaits", At::kTask, sleep_often, "one turn waited"},
                    TurnCase{"WatchThatComputes", At::kWatch, kTooLong, "one turn took"},
                    TurnCase{"WatchThatReads", At::kWatch, read_much, "one turn read"},
                    TurnCase{"ServeThatComputes", At::kServe, kTooLong, "one turn took"},
                    TurnCase{"ServeThatWaits", At::kServe, sleep_often, "one turn waited"},
                    TurnCase{"ServeThatReads", At::kServe, read_much, "one turn read"}),
    [](const auto& test) { return test.param.name; });

TEST(MeteredTurnWithinItsBounds, GoesOn) {
  for (const At at : {At::kTask, At::kWatch, At::kServe}) {
    std::atomic<int> ran{0};
    turn_with(at, [&ran] {
      ++ran;
      compute(std::chrono::milliseconds(1));
      ::poll(nullptr, 0, 1);
    });
    EXPECT_GE(ran, 1);
  }
}

TEST(LinkLoop, ATaskThatLacksMemoryIsTriedAgain) {
  LinkLoop loop("fixture", {});
  loop.start();
  std::atomic<int> tries{0};
  loop.run_on_loop([&] {
    if (++tries < 3) throw std::bad_alloc();
  });
  EXPECT_EQ(tries, 3);
  loop.stop();
}

}  // namespace
}  // namespace cas::casd::test
