// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/hop_account.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

using Direction = base::LedgerEntry::Direction;

constexpr std::uint32_t kSensor = 107;
constexpr StreamWindow kWindow{.begin_usec = 1, .end_usec = 100};
const PacketPath kUp{"HIL_SENSOR", kSensor, true};

base::RunTime us(std::int64_t t) { return base::RunTime(std::chrono::microseconds(t)); }

casd::PacketInfo info(std::uint64_t stamp, std::int64_t received_us) {
  casd::PacketInfo info;
  info.message_id = kSensor;
  info.hil_time_usec = stamp;
  info.received = us(received_us);
  return info;
}

base::LedgerEntry entry(Direction direction, std::uint64_t stamp, std::int64_t at_us) {
  return {direction, kSensor, stamp, at_us * 1000};
}

/// Ten packets that take 10, 5 and 100 us for the three hops.
struct Bench {
  std::vector<base::LedgerEntry> simulator;
  std::vector<base::LedgerEntry> controller;
  RelayLedgers relay;

  enum class Fate { kArrives, kLostToCasd, kDropped, kLostOnTheLine, kVanishes };
  void pass(std::uint64_t stamp, Fate fate = Fate::kArrives) {
    const auto t = static_cast<std::int64_t>(1000 * stamp);
    simulator.push_back(entry(Direction::kSent, stamp, t));
    if (fate == Fate::kLostToCasd) return;
    relay.simulator.received(info(stamp, t + 10));
    if (fate == Fate::kVanishes) return;
    if (fate == Fate::kDropped) {
      return relay.controller.dropped(info(stamp, t + 10), casd::DropCause::kAge, us(t + 15));
    }
    relay.controller.sent(info(stamp, t + 10), us(t + 15));
    if (fate == Fate::kLostOnTheLine) return;
    controller.push_back(entry(Direction::kReceived, stamp, t + 115));
  }
  PathAccount account() const { return account_path(kUp, simulator, controller, &relay, kWindow); }
};

TEST(HopAccount, FollowsEachPacketFromHopToHop) {
  Bench bench;
  for (std::uint64_t stamp = 1; stamp <= 10; ++stamp) bench.pass(stamp);
  const PathAccount account = bench.account();
  EXPECT_TRUE(account.closes()) << account.open;
  EXPECT_EQ(account.received, 10U);
  ASSERT_EQ(account.hops.size(), 3U);
  EXPECT_DOUBLE_EQ(account.hops[0].delay.p50, 10);
  EXPECT_DOUBLE_EQ(account.hops[1].delay.p50, 5);
  EXPECT_DOUBLE_EQ(account.hops[2].delay.p50, 100);
  EXPECT_DOUBLE_EQ(account.hops[2].jitter_us, 0);
}

TEST(HopAccount, NamesTheCauseOfEachLoss) {
  Bench bench;
  bench.pass(1);
  bench.pass(2, Bench::Fate::kLostToCasd);
  bench.pass(3, Bench::Fate::kDropped);
  bench.pass(4, Bench::Fate::kLostOnTheLine);
  bench.pass(5, Bench::Fate::kLostOnTheLine);
  const PathAccount account = bench.account();
  EXPECT_TRUE(account.closes()) << account.open;
  EXPECT_EQ(account.received, 1U);
  const std::map<std::string, std::uint64_t> expected{{"in the socket of the receiver", 1},
                                                      {"too old in casd's queue", 1},
                                                      {"on the serial line", 2}};
  EXPECT_EQ(account.losses, expected);
}

TEST(HopAccount, StaysOpenWhenAPacketVanishesInCasd) {
  Bench bench;
  bench.pass(1);
  bench.pass(2, Bench::Fate::kVanishes);
  EXPECT_FALSE(bench.account().closes());
}

TEST(HopAccount, StaysOpenWhenAPacketAppearsOrComesTwice) {
  Bench bench;
  bench.pass(1);
  bench.controller.push_back(entry(Direction::kReceived, 2, 2000));
  EXPECT_FALSE(bench.account().closes());
  bench.controller.back().time_usec = 1;
  EXPECT_FALSE(bench.account().closes());
}

TEST(HopAccount, ComparesTheEndsWhereCasdKeptNoLedger) {
  Bench bench;
  bench.pass(1);
  bench.pass(2, Bench::Fate::kDropped);
  const PathAccount account =
      account_path(kUp, bench.simulator, bench.controller, nullptr, kWindow);
  EXPECT_TRUE(account.closes()) << account.open;
  ASSERT_EQ(account.hops.size(), 1U);
  EXPECT_EQ(account.losses.at("somewhere on the way"), 1U);
}

}  // namespace
}  // namespace cas::hils
