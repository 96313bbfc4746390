// SPDX-License-Identifier: BSD-3-Clause
#include "casd/queue/tx_queue.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

using enum TrafficClass;

constexpr std::size_t kPacket = 77;  // a HIL_SENSOR on the wire
constexpr unsigned kSlowBaud = 115200;

struct Drops {
  std::map<std::pair<TrafficClass, DropCause>, int> count;
  TxQueue::OnDrop counter() {
    return [this](const PacketInfo& packet, DropCause cause) { ++count[{packet.traffic, cause}]; };
  }
};

TEST(TxQueue, GivesBackWhatItTookInOrder) {
  TxQueue queue;
  for (std::uint8_t i = 0; i < 10; ++i) queue.push(info(kHil, at({})), bytes(kPacket, i));
  EXPECT_EQ(queue.count(), 10U);
  for (std::uint8_t i = 0; i < 10; ++i) {
    const auto next = queue.pop(at({}), {});
    ASSERT_TRUE(next);
    EXPECT_EQ(next->bytes.size(), kPacket);
    EXPECT_EQ(next->bytes.front(), i);
  }
  EXPECT_FALSE(queue.pop(at({}), {}));
  EXPECT_EQ(queue.high_water(), 10U);
}

TEST(TxQueue, DropsHilPacketsOnlyWhenTheyWouldArriveTooLate) {
  Drops drops;
  TxQueue queue({}, drops.counter());
  queue.push(info(kHil, at({})), bytes(kPacket));
  queue.push(info(kHil, at(milliseconds(20))), bytes(kPacket));
  const auto next = queue.pop(at(milliseconds(26)), {});
  ASSERT_TRUE(next);
  EXPECT_EQ(next->info.received, at(milliseconds(20)));
  EXPECT_EQ((drops.count[{kHil, DropCause::kAge}]), 1);
}

TEST(TxQueue, BurstThatTheLineCarriesInTimeLosesNothing) {
  Drops drops;
  TxQueue queue({}, drops.counter());
  LinePacer line(LinePacer::rate_of(921600));
  constexpr int kBurst = 20;  // 1540 bytes: 17 ms of this line
  for (int i = 0; i < kBurst; ++i) queue.push(info(kHil, at({})), bytes(kPacket));
  int sent = 0;
  for (base::Duration now{}; !queue.empty(); now += microseconds(100)) {
    while (line.ready(at(now))) {
      const auto next = queue.pop(at(now), line);
      if (!next) break;
      line.sent(next->bytes.size(), at(now));
      ++sent;
    }
  }
  EXPECT_EQ(sent, kBurst);
  EXPECT_TRUE(drops.count.empty());
}

/// Runs a saturated line for ten seconds. @return the greatest age at arrival, by class
std::map<TrafficClass, base::Duration> saturate(TxQueue& queue, std::map<TrafficClass, int>& sent) {
  LinePacer line(LinePacer::rate_of(kSlowBaud));
  std::map<TrafficClass, base::Duration> oldest;
  for (base::Duration now{}; now < std::chrono::seconds(10); now += microseconds(500)) {
    if (now % milliseconds(2) == base::Duration{}) {
      queue.push(info(kHil, at(now)), bytes(kPacket));
    }
    if (now % milliseconds(200) == base::Duration{}) queue.push(info(kGps, at(now)), bytes(51));
    if (now % milliseconds(100) == base::Duration{}) {
      queue.push(info(kCommand, at(now)), bytes(45));
    }
    if (now % milliseconds(20) == base::Duration{}) {
      queue.push(info(kTelemetry, at(now)), bytes(40));
    }
    while (line.ready(at(now))) {
      const auto next = queue.pop(at(now), line);
      if (!next) break;
      line.sent(next->bytes.size(), at(now));
      const base::Duration age = line.arrival(0, at(now)) - next->info.received;
      oldest[next->info.traffic] = std::max(oldest[next->info.traffic], age);
      ++sent[next->info.traffic];
    }
  }
  return oldest;
}

TEST(TxQueue, SaturatedLineStaysFreshAndStarvesNobodyButTelemetry) {
  Drops drops;
  TxQueue queue({}, drops.counter());
  std::map<TrafficClass, int> sent;
  auto oldest = saturate(queue, sent);
  EXPECT_LE(oldest[kHil], milliseconds(25));
  EXPECT_EQ(sent[kGps], 50);
  EXPECT_EQ(sent[kCommand], 100);
  EXPECT_LE(oldest[kGps], milliseconds(40));
  EXPECT_LE(oldest[kCommand], milliseconds(40));
  EXPECT_EQ((drops.count[{kCommand, DropCause::kQueueFull}]), 0);
  // 11.29 kB/s, less 4.5 of commands and 0.26 of GPS, are 1370 HIL packets in ten seconds.
  EXPECT_GT(sent[kHil], 1300);
}

TEST(TxQueue, CommandsAreNeverDroppedWhileTheirClassHasRoomAndShareTheLine) {
  Drops drops;
  TxQueue queue({}, drops.counter());
  constexpr int kCommands = 200;
  for (int i = 0; i < kCommands; ++i) queue.push(info(kCommand, at({})), bytes(45));
  std::map<TrafficClass, int> sent;
  const auto oldest = saturate(queue, sent);
  EXPECT_EQ(sent[kCommand], kCommands + 100);
  EXPECT_LE(oldest.at(kHil), milliseconds(25));  // 9 kB of commands delay no sensor packet
  EXPECT_EQ(drops.count.count({kCommand, DropCause::kAge}), 0U);
}

TEST(TxQueue, FullCommandClassRefusesTheNewOne) {
  Drops drops;
  TxQueue queue({.command_bytes = 1024}, drops.counter());
  int taken = 0;
  while (queue.push(info(kCommand, at({})), bytes(45))) ++taken;
  EXPECT_GT(taken, 5);
  EXPECT_EQ(queue.count(), static_cast<std::size_t>(taken));
  EXPECT_EQ((drops.count[{kCommand, DropCause::kQueueFull}]), 1);
}

TEST(TxQueue, FullTelemetryClassDropsTheOldest) {
  Drops drops;
  TxQueue queue({.telemetry_bytes = 1024}, drops.counter());
  for (std::uint8_t i = 0; i < 100; ++i) queue.push(info(kTelemetry, at({})), bytes(40, i));
  std::uint8_t last = 0;
  while (const auto next = queue.pop(at({}), {})) last = next->bytes.front();
  EXPECT_EQ(last, 99);
  EXPECT_GT((drops.count[{kTelemetry, DropCause::kQueueFull}]), 80);
}

TEST(TxQueue, TelemetryWaitsForEverythingElse) {
  TxQueue queue;
  queue.push(info(kTelemetry, at({})), bytes(40));
  queue.push(info(kHil, at({})), bytes(40));
  queue.push(info(kCommand, at({})), bytes(40));
  queue.push(info(kGps, at({})), bytes(40));
  std::vector<TrafficClass> order;
  while (const auto next = queue.pop(at({}), {})) order.push_back(next->info.traffic);
  EXPECT_EQ(order.back(), kTelemetry);
  EXPECT_EQ(order.size(), 4U);
}

TEST(TxQueue, LineThatIsTooSlowForTheAgeLimitStillGetsTheNewestPacket) {
  TxQueue queue;
  LinePacer line(LinePacer::rate_of(9600));  // 82 ms for one HIL_SENSOR
  int sent = 0;
  for (base::Duration now{}; now < std::chrono::seconds(5); now += milliseconds(2)) {
    queue.push(info(kHil, at(now)), bytes(kPacket));
    if (!line.ready(at(now))) continue;
    if (const auto next = queue.pop(at(now), line)) {
      line.sent(next->bytes.size(), at(now));
      ++sent;
    }
  }
  EXPECT_GE(sent, 58);  // 5 s / 82 ms, less the first and last
}

TEST(TxQueue, SetpointsDieAtTheirAge) {
  Drops drops;
  TxQueue queue({}, drops.counter());
  queue.push(info(kSetpoint, at({}), 69), bytes(30));
  queue.push(info(kSetpoint, at(milliseconds(100)), 70), bytes(30));
  const auto next = queue.pop(at(milliseconds(501)), {});
  ASSERT_TRUE(next);
  EXPECT_EQ(next->info.message_id, 70U);
  EXPECT_EQ((drops.count[{kSetpoint, DropCause::kAge}]), 1);
  EXPECT_FALSE(queue.pop(at(milliseconds(501)), {}));
}

TEST(TxQueue, CountsTheWaitBeforeItWasRead) {
  TxQueue queue;
  PacketInfo stick = info(kSetpoint, at({}), 69);
  stick.waited = milliseconds(450);
  queue.push(stick, bytes(30));
  EXPECT_FALSE(queue.pop(at(milliseconds(60)), {}));
}

TEST(TxQueue, StickComesThroughAFloodOfCommands) {
  TxQueue queue;
  for (int i = 0; i < 100; ++i) queue.push(info(kCommand, at({})), bytes(250));
  ASSERT_TRUE(queue.pop(at({}), {}));
  queue.push(info(kSetpoint, at({}), 69), bytes(30));
  int before = 0;
  for (auto next = queue.pop(at({}), {}); next->info.traffic != kSetpoint;
       next = queue.pop(at({}), {})) {
    ++before;
  }
  EXPECT_LE(before, 1);
}

TEST(TxQueue, ClearCountsEveryPacket) {
  Drops drops;
  TxQueue queue({}, drops.counter());
  queue.push(info(kHil, at({})), bytes(40));
  queue.push(info(kCommand, at({})), bytes(40));
  queue.push(info(kSetpoint, at({})), bytes(40));
  queue.clear(DropCause::kClosed);
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ((drops.count[{kHil, DropCause::kClosed}]), 1);
  EXPECT_EQ((drops.count[{kCommand, DropCause::kClosed}]), 1);
  EXPECT_EQ((drops.count[{kSetpoint, DropCause::kClosed}]), 1);
}

}  // namespace
}  // namespace cas::casd::test
