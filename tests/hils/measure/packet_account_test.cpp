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

/// What arrives of a stream 1 ms later, without the stamps that `lost` names.
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

}  // namespace
}  // namespace cas::hils
