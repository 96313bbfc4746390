// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/plugins/datagram_peer.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/recording_port.hpp"

namespace cas::sim {
namespace {

using std::chrono::milliseconds;
namespace mv = mavlink::common;
using Peer = test::DatagramPeer;
using test::at_ms;
using test::controls_for;
using test::RecordingPort;
using test::updated;

constexpr base::Duration kPatience = std::chrono::seconds(10);  // deadline, not a wait

TEST(MavlinkInterfacePlugin, CarriesTheSensorsOfOneSecondOverTheBus) {
  test::PluginHarness harness;
  harness.add("imu", "{rate_hz: 500, gyro_stddev_deg_s: 1, accel_stddev_m_s2: 0.05}");
  harness.add("gps",
              "{rate_hz: 5, position_stddev_m: 0.3, velocity_stddev_m_s: 0.1, eph_m: 0.42, "
              "epv_m: 0.3, satellites: 10}");
  harness.add("magnetometer", "{rate_hz: 100, stddev_gauss: 0.004}");
  harness.add("barometer", "{rate_hz: 50, stddev_pa: 1}");
  Plugin& plugin = harness.add("mavlink_interface", "{transport: bus}");
  RecordingPort recorder;
  const auto listening =
      harness.bus.subscribe<WirePacket>("iris0/wire_out", [&](const WirePacket& packet) {
        recorder.send({packet.bytes.data(), packet.size});
      });
  harness.run(std::chrono::seconds(1));

  EXPECT_EQ(recorder.sensors.size(), 500U);
  EXPECT_EQ(recorder.fixes.size(), 5U);
  int magnetic = 0;
  int baric = 0;
  for (const auto& sensor : recorder.sensors) {
    magnetic += (updated(sensor) & kUpdatedMag) == kUpdatedMag;
    baric += (updated(sensor) & kUpdatedBaro) == kUpdatedBaro;
    EXPECT_EQ(updated(sensor) & 0x3FU, 0x3FU);
  }
  EXPECT_EQ(magnetic, 100);
  EXPECT_EQ(baric, 50);
  EXPECT_NEAR(recorder.sensors.back().zacc, -test::kGravity, 0.5);
  EXPECT_NE(plugin.stats_json().find("\"HIL_SENSOR\":500"), std::string::npos);
}

TEST(MavlinkInterfacePlugin, TurnsControlsFromTheBusIntoAMotorCommand) {
  test::PluginHarness harness;
  const auto wire_in = harness.bus.advertise<WirePacket>("iris0/wire_in");
  harness.add("mavlink_interface", "{transport: bus}");
  std::vector<MotorCommand> commands;
  const auto listening = harness.bus.subscribe<MotorCommand>(
      "iris0/motor_command", [&](const MotorCommand& command) { commands.push_back(command); });
  mav::Encoder encoder({1, 1});
  const auto bytes = encoder(controls_for(0, 1.0F));
  WirePacket packet{.size = bytes.size()};
  std::copy(bytes.begin(), bytes.end(), packet.bytes.begin());
  wire_in.publish(packet);
  harness.step();
  ASSERT_EQ(commands.size(), 1U);
  EXPECT_TRUE(commands[0].armed);
  EXPECT_NEAR(commands[0].values[0], 28.2656, 1e-4);  // the vehicle's full scale
}

mv::CommandLong truth_each(float interval_us) {
  return {.command = mv::MavCmd::kSetMessageInterval,
          .param1 = mv::HilStateQuaternion::kId,
          .param2 = interval_us};
}

/// A socket of an aircraft in HITL that asks for the truth, and of a viewer beside it.
TEST(MavlinkInterfacePlugin, ShowsTheTruthToAViewerAndNeverToAControllerInHitl) {
  Peer controller;
  Peer viewer;
  test::PluginHarness harness;
  harness.world.body.p_WB = {0, 0, 7};
  harness.add("imu", "{rate_hz: 500, gyro_stddev_deg_s: 1, accel_stddev_m_s2: 0.05}");
  Plugin& plugin =
      harness.add("mavlink_interface", "{transport: udp, local: '127.0.0.1:0', remote: '" +
                                           controller.endpoint() + "', viewer: {remote: '" +
                                           viewer.endpoint() + "', rate_hz: 20}}");
  const std::string stats = plugin.stats_json();
  const std::size_t start = stats.find("udp ") + 4;
  mav::Encoder encoder({1, 1});
  controller.send_to(stats.substr(start, stats.find('"', start) - start),
                     encoder(truth_each(5000)));
  harness.run(milliseconds(200));

  RecordingPort line;
  for (int i = 0; i < 101; ++i) line.send(controller.receive());  // HEARTBEAT and HIL_SENSORs
  EXPECT_EQ(line.sensors.size(), 100U);
  EXPECT_NE(plugin.stats_json().find("\"COMMAND_LONG\":1"), std::string::npos) << "it was asked";
  EXPECT_EQ(plugin.stats_json().find("HIL_STATE_QUATERNION"), std::string::npos);
  RecordingPort shown;
  for (int i = 0; i < 4; ++i) shown.send(viewer.receive());
  EXPECT_EQ(shown.ids, std::vector<std::uint32_t>(4, mv::HilStateQuaternion::kId));
  EXPECT_NE(plugin.stats_json().find("\"sent\":4"), std::string::npos) << "and no more";
  const mav::PacketView last = mav::view_packet(shown.packets.back());
  const auto truth = mav::decode<mv::HilStateQuaternion>(last);
  ASSERT_TRUE(truth);
  EXPECT_EQ(last.source, (mav::Source{1, 200}));
  EXPECT_EQ(truth->time_usec, 200'000U);
  EXPECT_EQ(truth->alt, 495'000);  // home is at 488 m
}

TEST(MavlinkInterfacePlugin, HoldsLockstepUntilTheAnswerArrivesOverUdp) {
  Peer peer;
  test::PluginHarness harness;
  harness.add("imu", "{rate_hz: 500, gyro_stddev_deg_s: 1, accel_stddev_m_s2: 0.05}");
  Plugin& plugin =
      harness.add("mavlink_interface",
                  "{transport: udp, local: '127.0.0.1:0', remote: '" + peer.endpoint() + "'}");
  ASSERT_NE(harness.context.lockstep_peer, nullptr);
  LockstepPeer& lockstep = *harness.context.lockstep_peer;
  harness.run(milliseconds(3));
  EXPECT_TRUE(lockstep.wait_for_controls(at_ms(3), kPatience));  // 2 ms: no answer is due
  harness.step();
  EXPECT_FALSE(lockstep.wait_for_controls(at_ms(4), milliseconds(1)));

  const std::string stats = plugin.stats_json();
  const std::size_t start = stats.find("udp ") + 4;
  mav::Encoder encoder({1, 1});
  peer.send_to(stats.substr(start, stats.find('"', start) - start), encoder(controls_for(4)));
  EXPECT_TRUE(lockstep.wait_for_controls(at_ms(4), kPatience));
}

}  // namespace
}  // namespace cas::sim
