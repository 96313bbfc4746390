// SPDX-License-Identifier: BSD-3-Clause
// Pulses of a stock ArduPilot board (SERVO_OUTPUT_RAW) as outputs of the vehicle.
#include <gtest/gtest.h>

#include "plugins/mavlink_interface/hil_interface.hpp"
#include "plugins/mavlink_interface/servo_map.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/recording_port.hpp"
#include "tests/support/refusal.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;
using test::at_ms;
using test::RecordingPort;

ServoMap map_of(const std::string& yaml, const std::string& vehicle = "iris_px4") {
  const base::ConfigNode node = base::ConfigNode::parse(yaml);
  ServoMap map(node, test::load_vehicle(vehicle));
  node.reject_unused();
  return map;
}

mv::ServoOutputRaw pulses(std::uint16_t first, std::uint16_t second, std::uint16_t third,
                          std::uint16_t fourth) {
  return {.servo1_raw = first, .servo2_raw = second, .servo3_raw = third, .servo4_raw = fourth};
}

TEST(ServoMap, ScalesARotorBetweenItsEnds) {
  const ServoMap usual = map_of("{}");
  const MotorCommand command = usual.to_motor_command(pulses(1000, 1703, 2200, 0));
  EXPECT_EQ(command.kind, MotorCommand::Kind::kMotorOutputs);
  EXPECT_TRUE(command.armed);
  EXPECT_TRUE(command.values.head<4>().isApprox(Eigen::Vector4d(0, 0.703, 1, 0), 1e-12));
  EXPECT_FALSE(usual.to_motor_command(pulses(1000, 1000, 1000, 1000)).armed);
  EXPECT_FALSE(usual.to_motor_command(pulses(0, 0, 0, 0)).armed) << "no output";
}

TEST(ServoMap, TakesTheRangeOfSingleOutputs) {
  const ServoMap map = map_of("{min_us: 1100, max_us: 1900, channels: {2: {max_us: 2100}}}");
  const MotorCommand command = map.to_motor_command(pulses(1500, 1500, 1100, 1900));
  EXPECT_TRUE(command.values.head<4>().isApprox(Eigen::Vector4d(0.5, 0.4, 0, 1), 1e-12));
}

TEST(ServoMap, ScalesASurfaceAboutItsTrim) {
  const base::Vehicle plane = test::load_vehicle("plane");
  ASSERT_FALSE(plane.aero->surfaces.empty());
  const int output = plane.aero->surfaces.front().output;
  const ServoMap map = map_of("{channels: {" + std::to_string(output + 1) +
                                  ": {min_us: 1000, trim_us: 1400, max_us: 2000}}}",
                              "plane");
  const auto value = [&](std::uint16_t pulse) {
    mv::ServoOutputRaw packet = pulses(pulse, pulse, pulse, pulse);
    packet.servo5_raw = packet.servo6_raw = packet.servo7_raw = packet.servo8_raw = pulse;
    return map.to_motor_command(packet).values[output];
  };
  EXPECT_NEAR(value(1400), 0, 1e-12);
  EXPECT_NEAR(value(1700), 0.5, 1e-12);
  EXPECT_NEAR(value(1200), -0.5, 1e-12);
  EXPECT_NEAR(value(800), -1, 1e-12);
}

TEST(ServoMap, RefusesRangesThatDoNotRise) {
  const auto refusal = [](const std::string& yaml) { return test::refusal([&] { map_of(yaml); }); };
  EXPECT_NE(refusal("{min_us: 1600}").find("do not rise"), std::string::npos);
  EXPECT_NE(refusal("{channels: {17: {max_us: 1900}}}").find("no output from 1 to 16"),
            std::string::npos);
  EXPECT_NE(refusal("{channels: {1: {max_us: 1200}}}").find("do not rise"), std::string::npos);
}

HilInterfaceParams with_servos() {
  HilInterfaceParams params;
  params.actuator_timeout = std::chrono::milliseconds(500);
  params.servos = map_of("{}");
  return params;
}

TEST(ServoOutputs, DriveTheRotorsAndNoSensorIsSent) {
  RecordingPort port;
  HilInterface interface(with_servos(), port, nullptr);
  ImuSample sample{.time = at_ms(4)};
  GpsSample fix;
  fix.time = at_ms(4);
  interface.on_imu(sample);
  interface.on_gps(fix);
  interface.flush(at_ms(4));
  EXPECT_TRUE(port.sensors.empty());
  EXPECT_TRUE(port.fixes.empty());
  port.put(pulses(1100, 1200, 1300, 1400));
  interface.receive();
  const auto command = interface.take_command(at_ms(5));
  ASSERT_TRUE(command);
  EXPECT_NEAR(command->values[2], 0.3, 1e-12);
  const auto stop = interface.take_command(at_ms(600));
  ASSERT_TRUE(stop) << "the stream ended";
  EXPECT_FALSE(stop->armed);
}

TEST(ServoOutputs, OfSecondPortOrWithoutAMapAreLeftAlone) {
  RecordingPort port;
  HilInterface interface(with_servos(), port, nullptr);
  mv::ServoOutputRaw others = pulses(1900, 1900, 1900, 1900);
  others.port = 1;
  port.put(others);
  interface.receive();
  EXPECT_FALSE(interface.take_command(at_ms(5)));
  HilInterface without({}, port, nullptr);
  port.put(pulses(1900, 1900, 1900, 1900));
  without.receive();
  EXPECT_FALSE(without.take_command(at_ms(5)));
}

}  // namespace
}  // namespace cas::sim
