// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/local_endpoint.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "casd/station/vehicle_commander.hpp"
#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

constexpr mav::Source kVehicle{1, 1};
constexpr mav::Source kSelf{254, 190};

/// Keeps the ids of its packets.
class Listener final : public Station {
 public:
  void on_packet(const Origin&, const mav::PacketView& packet, base::RunTime) override {
    heard.push_back(packet.message_id);
  }
  void tick(base::RunTime) override {}

  std::vector<std::uint32_t> heard;
};

class LocalEndpointTest : public testing::Test {
 protected:
  template <class Message>
  void deliver(const Message& message) {
    const mav::PacketBuffer buffer = packet(message, kVehicle);
    const PacketInfo info = inspect(view(buffer), mav::public_table());
    const PacketRef reference{&info, buffer.view()};
    endpoint_.deliver({&reference, 1}, at(milliseconds(0)));
  }
  void deliver_telemetry() { deliver(mavlink::common::Heartbeat{}); }
  void deliver_answer() {
    mavlink::common::CommandAck answer{.target_system = kSelf.system,
                                       .target_component = kSelf.component};
    deliver(answer);
  }
  bool wakes() const {
    pollfd entry{endpoint_.descriptor(), POLLIN, 0};
    return ::poll(&entry, 1, 0) == 1;
  }
  std::size_t dispatch() {
    Listener listener;
    endpoint_.dispatch(listener, at(milliseconds(0)));
    return listener.heard.size();
  }

  Switchboard switchboard_{std::make_shared<RoutingPlan>()};
  LocalEndpoint endpoint_{switchboard_, kSelf};
};

TEST_F(LocalEndpointTest, EveryPacketWakesItsReaderAtFirst) {
  EXPECT_FALSE(wakes());
  deliver_telemetry();
  EXPECT_TRUE(wakes());
  EXPECT_EQ(dispatch(), 1U);
  EXPECT_FALSE(wakes());
}

TEST_F(LocalEndpointTest, TelemetryThatIsToWakeNobodyIsHeardWithTheNextAnswer) {
  endpoint_.wake_for_all(false);
  deliver_telemetry();
  deliver_telemetry();
  EXPECT_FALSE(wakes());
  deliver_answer();
  EXPECT_TRUE(wakes());
  EXPECT_EQ(dispatch(), 3U);
}

TEST_F(LocalEndpointTest, WhatWaitsIsDispatchedWithoutAWakeUp) {
  endpoint_.wake_for_all(false);
  deliver_telemetry();
  EXPECT_EQ(dispatch(), 1U);
  endpoint_.wake_for_all(true);
  deliver_telemetry();
  EXPECT_TRUE(wakes());
}

/// Gets no memory for its first packet.
class LackingListener final : public Station {
 public:
  void on_packet(const Origin&, const mav::PacketView&, base::RunTime) override {
    if (++packets == 1) throw std::bad_alloc();
  }
  void tick(base::RunTime) override {}

  int packets = 0;
};

TEST_F(LocalEndpointTest, LackOfMemoryCostsOnePacket) {
  deliver_telemetry();
  deliver_answer();
  LackingListener listener;
  endpoint_.dispatch(listener, at(milliseconds(0)));
  EXPECT_EQ(listener.packets, 2);
}

class LackingPort final : public PacketPort {
 public:
  void deliver(std::span<const PacketRef>, base::RunTime) override { throw std::bad_alloc(); }
};

class CountingPort final : public PacketPort {
 public:
  void deliver(std::span<const PacketRef> packets, base::RunTime) override {
    count += packets.size();
  }
  std::size_t count = 0;
};

TEST(DeliveryBatch, ADestinationThatLacksMemoryCostsTheOthersNothing) {
  const auto taking = std::make_shared<CountingPort>();
  PortTable ports{};
  ports[1] = std::make_shared<LackingPort>();
  ports[2] = taking;
  DeliveryBatch batch;
  const std::array<std::uint8_t, 3> bytes{1, 2, 3};
  batch.add({}, bytes, bit(1) | bit(2));
  batch.add({}, bytes, bit(1) | bit(2));
  EXPECT_EQ(batch.deliver(ports, at(milliseconds(0))), 2U);
  EXPECT_EQ(taking->count, 2U);
  EXPECT_TRUE(batch.empty());
}

}  // namespace
}  // namespace cas::casd::test
