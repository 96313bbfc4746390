// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual/virtual_relay.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "casd/topology/topology.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::hils {
namespace {

using mavlink::common::HilSensor;
using std::chrono::milliseconds;

constexpr base::RunTime at(base::Duration since_start) {
  return base::RunTime(std::chrono::seconds(1) + since_start);
}

/// @param of_sim  further keys of the simulator's link
casd::Topology topology(const std::string& threads, const std::string& of_sim = {}) {
  return casd::Topology::parse(base::ConfigNode::parse("threads: " + threads + R"(
schema: 1
drain_tick_ms: 0
commanding: {heartbeat_hz: 0}
links:
  - {name: sim, type: udp, local: '127.0.0.1:1')" + of_sim +
                                                           R"(}
  - {name: ear, type: udp, remote: '127.0.0.1:2', sniffer: true}
  - {name: fcu, type: serial, device: /dev/fcu, baud: 115200}
  - {name: fcu2, type: serial, device: /dev/fcu2, baud: 115200}
routes:
  - {from: sim, to: fcu}
  - {from: sim, to: fcu2}
)",
                                                       "test"));
}

/// A line as casd's port sees it.
struct Line {
  std::size_t room = 1'000'000;
  std::vector<std::uint8_t> bytes;
  std::vector<base::RunTime> writes;

  VirtualRelay::Write taker() {
    return [this](std::span<const std::uint8_t> given, base::RunTime now) {
      const std::size_t taken = std::min(room, given.size());
      room -= taken;
      if (taken > 0) writes.push_back(now);
      bytes.insert(bytes.end(), given.begin(), given.begin() + static_cast<std::ptrdiff_t>(taken));
      return taken;
    };
  }
};

class VirtualRelayTest : public testing::Test {
 protected:
  void open(const std::string& threads, const std::string& of_sim = {}) {
    relay.emplace(topology(threads, of_sim), WakeUp({}, 1));
    relay->connect(relay->link("ear"), ear.taker());
    relay->connect(relay->link("fcu"), line.taker());
    relay->connect(relay->link("fcu2"), other_line.taker());
    relay->run(at({}));
  }
  /// A HIL_SENSOR of the simulator, stamped with the time at which it comes.
  std::size_t sensor_comes(base::RunTime now) {
    HilSensor sensor;
    sensor.time_usec = static_cast<std::uint64_t>(now.time_since_epoch().count() / 1000);
    mav::PacketBuffer packet;
    packet.size = mav::encode(sensor, {1, 200}, sequence++, packet.bytes);
    relay->receive(relay->link("sim"), packet.view(), now);
    return packet.size;
  }

  std::optional<VirtualRelay> relay;
  Line line;
  Line other_line;
  Line ear;  ///< of the sniffer
  std::uint8_t sequence = 0;
};

TEST_F(VirtualRelayTest, WhatALineRefusesGrowsOldAsInCasd) {
  open("per_link");
  line.room = 10;
  const std::size_t size = sensor_comes(at({}));  // is begun
  sensor_comes(at(milliseconds(5)));              // waits
  line.room = 1'000'000;
  relay->run(at(milliseconds(100)));
  EXPECT_EQ(line.bytes.size(), size) << "the packet that was begun is finished";
  EXPECT_NE(line.bytes.back(), other_line.bytes[size - 1]) << "but with a wrong checksum";
  const casd::LinkLedger& ledger = relay->ledger(relay->link("fcu"));
  EXPECT_TRUE(ledger.sent().empty());
  ASSERT_EQ(ledger.dropped().size(), 2U);
  for (const casd::LinkLedgerEntry& entry : ledger.dropped()) {
    EXPECT_EQ(entry.cause, casd::DropCause::kAge);
    EXPECT_EQ(base::RunTime(base::Duration(entry.at_ns)), at(milliseconds(100)));
  }
}

TEST_F(VirtualRelayTest, OneThreadWaitsForOneLineAfterTheOther) {
  open("blocking");
  const std::size_t size = sensor_comes(at({}));
  ASSERT_EQ(line.writes.size(), 1U);
  ASSERT_EQ(other_line.writes.size(), 1U);
  const double line_s = 10.0 * static_cast<double>(size) / 115200;
  EXPECT_EQ(line.writes[0], at({}));
  EXPECT_GE(base::to_seconds(other_line.writes[0] - line.writes[0]), line_s);

  // A packet that comes while the thread waits is written after both.
  sensor_comes(at(milliseconds(1)));
  EXPECT_EQ(line.writes.size(), 1U);
  const base::RunTime through = relay->next_event();
  EXPECT_GE(base::to_seconds(through - at({})), 2 * line_s);
  relay->run(through);
  ASSERT_EQ(line.writes.size(), 2U);
  EXPECT_EQ(line.writes[1], through);
}

TEST_F(VirtualRelayTest, ALinkTakesInWhatItAccepts) {
  open("per_link", ", accept: {block_systems: [1]}");
  sensor_comes(at({}));
  EXPECT_TRUE(line.bytes.empty());
  EXPECT_TRUE(relay->ledger(relay->link("sim")).received().empty());

  open("per_link", ", accept: {systems: [1]}");
  const std::size_t size = sensor_comes(at(milliseconds(5)));
  EXPECT_EQ(line.bytes.size(), size);
}

TEST_F(VirtualRelayTest, ASnifferGetsWhatPassesOnOtherRoutes) {
  open("per_link");
  const std::size_t size = sensor_comes(at({}));
  EXPECT_EQ(ear.bytes.size(), size);
  EXPECT_EQ(ear.bytes, line.bytes);
}

TEST_F(VirtualRelayTest, NothingOfAKilledCasdIsSentByTheNextOne) {
  open("per_link");
  line.room = 10;
  sensor_comes(at({}));
  relay->kill();
  relay->restart();
  line.room = 1'000'000;
  relay->run(at(milliseconds(1)));
  EXPECT_EQ(line.bytes.size(), 10U);
  const casd::LinkLedger& ledger = relay->ledger(relay->link("fcu"));
  ASSERT_EQ(ledger.dropped().size(), 1U);
  EXPECT_EQ(ledger.dropped()[0].cause, casd::DropCause::kClosed);
  const std::size_t size = sensor_comes(at(milliseconds(2)));
  EXPECT_EQ(line.bytes.size(), 10 + size);
}

}  // namespace
}  // namespace cas::hils
