// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/packet_account.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cas::hils {
namespace {

using base::LedgerEntry;
using Direction = LedgerEntry::Direction;

constexpr std::uint32_t kSensor = 107;
constexpr std::uint32_t kControls = 91;
constexpr std::int64_t kMs = 1'000'000;

LedgerEntry sent(std::uint32_t id, std::uint64_t stamp, std::int64_t at) {
  return {Direction::kSent, id, stamp, at};
}
LedgerEntry received(std::uint32_t id, std::uint64_t stamp, std::int64_t at) {
  return {Direction::kReceived, id, stamp, at};
}

/// 500 Hz for `seconds`, sent at its own stamp.
std::vector<LedgerEntry> sensor_stream(std::uint64_t seconds) {
  std::vector<LedgerEntry> ledger;
  for (std::uint64_t stamp = 2000; stamp <= seconds * 1'000'000; stamp += 2000) {
    ledger.push_back(sent(kSensor, stamp, static_cast<std::int64_t>(stamp) * 1000));
  }
  return ledger;
}

/// The stream's arrivals, 1 ms later, without the stamps that `lost` names.
template <class Lost>
std::vector<LedgerEntry> arrivals(const std::vector<LedgerEntry>& stream, Lost lost) {
  std::vector<LedgerEntry> ledger;
  for (const LedgerEntry& entry : stream) {
    if (!lost(entry.time_usec)) {
      ledger.push_back(received(entry.message_id, entry.time_usec, entry.at_ns + kMs));
    }
  }
  return ledger;
}

constexpr StreamWindow kOneToThree{1'000'000, 3'000'000};
const auto kNone = [](std::uint64_t) { return false; };

TEST(Account, CountsACompleteStreamExactly) {
  const auto out = sensor_stream(4);
  const RateFigures rate = account(out, arrivals(out, kNone), kSensor, kOneToThree, 500);
  EXPECT_EQ(rate.sent, 1001U);  // both ends of the window are packets
  EXPECT_EQ(rate.received, 1001U);
  EXPECT_EQ(rate.lost, 0U);
  EXPECT_DOUBLE_EQ(rate.received_hz, 500.0);
  EXPECT_DOUBLE_EQ(rate.error_pct, 0.0);
  EXPECT_TRUE(rate.closes());
}

TEST(Account, SeesLossesAtTheEdgesOfTheWindow) {
  const auto out = sensor_stream(4);
  const auto at_the_edges = [](std::uint64_t stamp) {
    return stamp < 1'500'000 || stamp > 2'800'000;
  };
  const RateFigures rate = account(out, arrivals(out, at_the_edges), kSensor, kOneToThree, 500);
  EXPECT_EQ(rate.received, 651U);
  EXPECT_DOUBLE_EQ(rate.received_hz, 650 / (1.3 + 0.498 + 0.198));
}

TEST(Account, NamesEachLossOnce) {
  const auto out = sensor_stream(4);
  const auto every_tenth = [](std::uint64_t stamp) { return stamp % 20'000 == 2000; };
  const RateFigures rate = account(out, arrivals(out, every_tenth), kSensor, kOneToThree, 500);
  EXPECT_EQ(rate.sent, 1001U);
  EXPECT_EQ(rate.lost, 100U);
  EXPECT_EQ(rate.received, 901U);
  EXPECT_DOUBLE_EQ(rate.received_hz, 450.0);
  EXPECT_DOUBLE_EQ(rate.error_pct, 10.0);
}

TEST(Account, TakesPacketsThatAreStillUnderWayWhenTheWindowEnds) {
  const auto out = sensor_stream(4);
  auto in = arrivals(out, kNone);
  for (LedgerEntry& entry : in) entry.at_ns += 100 * kMs;  // long in the pipe
  const RateFigures rate = account(out, in, kSensor, kOneToThree, 500);
  EXPECT_EQ(rate.lost, 0U);
  EXPECT_TRUE(rate.drained);
}

TEST(Account, DoesNotCloseWhenTheStreamEndsWithTheWindow) {
  const auto out = sensor_stream(3);
  EXPECT_FALSE(account(out, arrivals(out, kNone), kSensor, kOneToThree, 500).closes());
}

/// Its rate is right from then on, so that the rate alone says nothing of it.
TEST(Account, DoesNotCloseWhenTheStreamBeginsInsideTheWindow) {
  auto out = sensor_stream(4);
  std::erase_if(out, [](const LedgerEntry& entry) { return entry.time_usec < 1'600'000; });
  const RateFigures late = account(out, arrivals(out, kNone), kSensor, kOneToThree, 500);
  EXPECT_NEAR(late.error_pct, 29.93, 0.01) << "silent for 0.6 of 2 s";
  EXPECT_TRUE(late.began_late);
  EXPECT_FALSE(late.closes());
  out = sensor_stream(4);
  std::erase_if(out, [](const LedgerEntry& entry) { return entry.time_usec < 1'400'000; });
  EXPECT_TRUE(account(out, arrivals(out, kNone), kSensor, kOneToThree, 500).closes());
}

TEST(Account, DoesNotCloseOnAPacketThatWasNeverSent) {
  const auto out = sensor_stream(4);
  auto in = arrivals(out, kNone);
  in.push_back(received(kSensor, 2'000'001, 2000 * kMs));
  const RateFigures rate = account(out, in, kSensor, kOneToThree, 500);
  EXPECT_EQ(rate.unexplained, 1U);
  EXPECT_EQ(rate.received, 1001U);
  EXPECT_FALSE(rate.closes());
}

TEST(Account, DoesNotCloseOnAPacketThatArrivedTwice) {
  const auto out = sensor_stream(4);
  auto in = arrivals(out, kNone);
  in.push_back(received(kSensor, 2'000'000, 2002 * kMs));
  const RateFigures rate = account(out, in, kSensor, kOneToThree, 500);
  EXPECT_EQ(rate.duplicated, 1U);
  EXPECT_EQ(rate.lost, 0U);
  EXPECT_FALSE(rate.closes());
}

TEST(Account, IsEmptyForAMessageThatNeverCame) {
  const auto out = sensor_stream(4);
  const RateFigures rate = account(out, {}, kControls, kOneToThree, 400);
  EXPECT_EQ(rate.sent, 0U);
  EXPECT_EQ(rate.received_hz, 0.0);
  EXPECT_EQ(rate.error_pct, 100.0);
}

TEST(EchoDelay, RunsFromTheSensorToItsOwnEcho) {
  std::vector<LedgerEntry> ledger = sensor_stream(4);
  ledger.push_back(received(kControls, 2'000'000, 2000 * kMs + 3 * kMs));
  ledger.push_back(received(kControls, 2'002'000, 2002 * kMs + 5 * kMs));
  ledger.push_back(received(kControls, 3'500'000, 3500 * kMs + 9 * kMs));  // outside the window
  const auto delays = echo_delays_ns(ledger, kSensor, kControls, kOneToThree);
  EXPECT_EQ(delays, (std::vector<std::int64_t>{3 * kMs, 5 * kMs}));
}

TEST(DelaySummary, UsesNearestRanks) {
  std::vector<std::int64_t> delays;
  for (std::int64_t i = 1; i <= 200; ++i) delays.push_back(i * 1000);
  const DelayFigures figures = summarise(delays);
  EXPECT_EQ(figures.count, 200U);
  EXPECT_DOUBLE_EQ(figures.p50, 100);
  EXPECT_DOUBLE_EQ(figures.p99, 198);
  EXPECT_DOUBLE_EQ(figures.max, 200);
}

TEST(Pace, IsOneForAStreamThatKeepsToItsStamps) {
  const PaceFigures figures = pace(sensor_stream(4), kSensor, kOneToThree);
  EXPECT_DOUBLE_EQ(figures.real_time_factor, 1.0);
  EXPECT_DOUBLE_EQ(figures.worst_stall_ms, 0.0);
}

TEST(Pace, ShowsAStreamThatRunsSlow) {
  auto out = sensor_stream(4);
  for (LedgerEntry& entry : out) entry.at_ns *= 2;
  EXPECT_DOUBLE_EQ(pace(out, kSensor, kOneToThree).real_time_factor, 0.5);
}

TEST(Pace, ShowsAStallThatWasCaughtUp) {
  auto out = sensor_stream(4);
  for (LedgerEntry& entry : out) {
    if (entry.time_usec >= 2'000'000 && entry.time_usec < 2'050'000) entry.at_ns = 2050 * kMs;
  }
  const PaceFigures figures = pace(out, kSensor, kOneToThree);
  EXPECT_DOUBLE_EQ(figures.real_time_factor, 1.0);
  EXPECT_DOUBLE_EQ(figures.worst_stall_ms, 50.0);
}

TEST(Pace, CountsLagThatIsNeverMadeUpOnceOnly) {
  auto out = sensor_stream(4);
  for (LedgerEntry& entry : out) {  // 30 ms are given up at 1.5 s, and again at 2.6 s
    if (entry.time_usec >= 1'500'000) entry.at_ns += 30 * kMs;
    if (entry.time_usec >= 2'600'000) entry.at_ns += 30 * kMs;
  }
  EXPECT_DOUBLE_EQ(pace(out, kSensor, kOneToThree).worst_stall_ms, 30.0);
}

// Hop by hop.

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

LedgerEntry hil_packet(Direction direction, std::uint64_t stamp, std::int64_t at_us) {
  return {direction, kSensor, stamp, at_us * 1000};
}

/// Ten packets that take 10, 5 and 100 us for the three hops.
struct HopLedgers {
  std::vector<LedgerEntry> simulator;
  std::vector<LedgerEntry> controller;
  RelayLedgers relay;

  enum class Fate { kArrives, kLostToCasd, kDropped, kLostOnTheLine, kVanishes };
  void pass(std::uint64_t stamp, Fate fate = Fate::kArrives) {
    const auto t = static_cast<std::int64_t>(1000 * stamp);
    simulator.push_back(hil_packet(Direction::kSent, stamp, t));
    if (fate == Fate::kLostToCasd) return;
    relay.simulator.received(info(stamp, t + 10));
    if (fate == Fate::kVanishes) return;
    if (fate == Fate::kDropped) {
      return relay.controller.dropped(info(stamp, t + 10), casd::DropCause::kAge, us(t + 15));
    }
    relay.controller.sent(info(stamp, t + 10), us(t + 15));
    if (fate == Fate::kLostOnTheLine) return;
    controller.push_back(hil_packet(Direction::kReceived, stamp, t + 115));
  }
  PathAccount account() const { return account_path(kUp, simulator, controller, &relay, kWindow); }
};

TEST(HopAccount, FollowsEachPacketFromHopToHop) {
  HopLedgers ledgers;
  for (std::uint64_t stamp = 1; stamp <= 10; ++stamp) ledgers.pass(stamp);
  const PathAccount account = ledgers.account();
  EXPECT_TRUE(account.closes()) << account.open;
  EXPECT_EQ(account.received, 10U);
  ASSERT_EQ(account.hops.size(), 3U);
  EXPECT_DOUBLE_EQ(account.hops[0].delay.p50, 10);
  EXPECT_DOUBLE_EQ(account.hops[1].delay.p50, 5);
  EXPECT_DOUBLE_EQ(account.hops[2].delay.p50, 100);
  EXPECT_DOUBLE_EQ(account.hops[2].jitter_us, 0);
}

TEST(HopAccount, AddsUpItsPauses) {
  HopLedgers ledgers;
  for (std::uint64_t stamp = 1; stamp <= 100; ++stamp) ledgers.pass(stamp);
  // Held up between casd and the controller: two pauses, the first with packets behind it that
  // waited less.
  constexpr std::int64_t kMs = 1'000'000;
  ledgers.controller[20].at_ns += 41 * kMs;
  ledgers.controller[21].at_ns += 39 * kMs;
  ledgers.controller[22].at_ns += 20 * kMs;
  ledgers.controller[60].at_ns += 30 * kMs;
  ledgers.controller[80].at_ns += 24 * kMs;  // no pause: casd keeps packets for longer
  const PathAccount account = ledgers.account();
  EXPECT_DOUBLE_EQ(account.hops[2].paused_ms, 71);
  EXPECT_DOUBLE_EQ(account.hops[0].paused_ms, 0);
}

TEST(HopAccount, NamesTheCauseOfEachLoss) {
  HopLedgers ledgers;
  ledgers.pass(1);
  ledgers.pass(2, HopLedgers::Fate::kLostToCasd);
  ledgers.pass(3, HopLedgers::Fate::kDropped);
  ledgers.pass(4, HopLedgers::Fate::kLostOnTheLine);
  ledgers.pass(5, HopLedgers::Fate::kLostOnTheLine);
  const PathAccount account = ledgers.account();
  EXPECT_TRUE(account.closes()) << account.open;
  EXPECT_EQ(account.received, 1U);
  const std::map<std::string, std::uint64_t> expected{{"in the socket of the receiver", 1},
                                                      {"too old in casd's queue", 1},
                                                      {"on the serial line", 2}};
  EXPECT_EQ(account.losses, expected);
}

TEST(HopAccount, StaysOpenWhenAPacketVanishesInCasd) {
  HopLedgers ledgers;
  ledgers.pass(1);
  ledgers.pass(2, HopLedgers::Fate::kVanishes);
  EXPECT_FALSE(ledgers.account().closes());
}

TEST(HopAccount, StaysOpenWhenAPacketAppearsOrComesTwice) {
  HopLedgers ledgers;
  ledgers.pass(1);
  ledgers.controller.push_back(hil_packet(Direction::kReceived, 2, 2000));
  EXPECT_FALSE(ledgers.account().closes());
  ledgers.controller.back().time_usec = 1;
  EXPECT_FALSE(ledgers.account().closes());
}

TEST(HopAccount, ComparesTheEndsWhereCasdKeptNoLedger) {
  HopLedgers ledgers;
  ledgers.pass(1);
  ledgers.pass(2, HopLedgers::Fate::kDropped);
  const PathAccount account =
      account_path(kUp, ledgers.simulator, ledgers.controller, nullptr, kWindow);
  EXPECT_TRUE(account.closes()) << account.open;
  ASSERT_EQ(account.hops.size(), 1U);
  EXPECT_EQ(account.losses.at("somewhere on the way"), 1U);
}

// The averaging meter.

std::vector<std::int64_t> steady(double hz, int seconds) {
  std::vector<std::int64_t> arrivals;
  for (int i = 0; i <= static_cast<int>(hz) * seconds; ++i) {
    arrivals.push_back(static_cast<std::int64_t>(i * 1e9 / hz));
  }
  return arrivals;
}

TEST(MeterReading, ReadsLowForAWhile) {
  struct MeterCase {
    int seconds;
    double shown_hz;
  };
  const MeterCase rows[] = {{5, 336}, {10, 446}, {20, 494}, {30, 499}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.seconds);
    const auto [seconds, shown_hz] = row;
    EXPECT_NEAR(averaging_meter_hz(steady(500, seconds), seconds * 1'000'000'000LL), shown_hz, 0.5);
  }
}

TEST(AveragingMeter, ShowsNothingForNothing) { EXPECT_EQ(averaging_meter_hz({}, 1), 0); }

}  // namespace
}  // namespace cas::hils
