// SPDX-License-Identifier: BSD-3-Clause
// Units, signs and bytes between the simulation and ArduPilot's SITL.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/earth/frames.hpp"
#include "plugins/ardupilot_json/json_messages.hpp"
#include "plugins/ardupilot_json/servo_clock.hpp"
#include "tests/plugins/plugin_harness.hpp"

namespace cas::sim {
namespace {

using std::chrono::microseconds;

std::vector<std::uint8_t> packet_bytes(std::uint16_t magic, int channels) {
  std::vector<std::uint8_t> bytes;
  const auto put = [&](unsigned value) {
    bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
    bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  };
  put(magic);
  put(1200);
  put(0x5678);
  put(0x1234);
  for (int i = 0; i < channels; ++i) put(1000U + static_cast<unsigned>(i));
  return bytes;
}

TEST(ServoPacket, ReadsBothSizesLittleEndian) {
  const auto small = parse_servo_packet(packet_bytes(18458, 16));
  ASSERT_TRUE(small);
  EXPECT_EQ(small->frame_rate_hz, 1200);
  EXPECT_EQ(small->frame_count, 0x12345678U);
  EXPECT_EQ(small->pwm_us[15], 1015);
  EXPECT_EQ(small->pwm_us[16], 0);
  const auto large = parse_servo_packet(packet_bytes(29569, 32));
  ASSERT_TRUE(large);
  EXPECT_EQ(large->pwm_us[31], 1031);
}

TEST(ServoPacket, RefusesWhatIsNeither) {
  EXPECT_EQ(packet_bytes(18458, 16).size(), 40U);
  EXPECT_FALSE(parse_servo_packet(packet_bytes(18458, 32)));
  EXPECT_FALSE(parse_servo_packet(packet_bytes(29569, 16)));
  EXPECT_FALSE(parse_servo_packet(packet_bytes(18459, 16)));
  EXPECT_FALSE(parse_servo_packet({}));
}

base::Vehicle rotors_on(std::initializer_list<int> outputs) {
  base::Vehicle vehicle;
  for (const int output : outputs) vehicle.rotors.emplace_back().output = output;
  return vehicle;
}

TEST(ServoPacket, PulsesBecomeOutputsAndThousandIsDisarmed) {
  ServoPacket packet;
  packet.pwm_us.fill(1000);
  const base::Vehicle quad = rotors_on({0, 1, 2, 3});
  EXPECT_FALSE(to_motor_command(packet, quad).armed);
  packet.pwm_us = {1703, 1150, 2100, 900};
  const MotorCommand command = to_motor_command(packet, quad);
  EXPECT_TRUE(command.armed);
  EXPECT_EQ(command.kind, MotorCommand::Kind::kMotorOutputs);
  EXPECT_TRUE(command.values.head<4>().isApprox(Eigen::Vector4d(0.703, 0.15, 1, 0), 1e-12));
  packet.pwm_us = {};  // no output yet
  EXPECT_FALSE(to_motor_command(packet, quad).armed);
}

TEST(ServoPacket, TricoptersTailServoIsNoMotor) {
  base::Vehicle tri = rotors_on({0, 1, 3});  // ArduPilot's: 1, 2, 4 and servo 7
  tri.rotors[2].tilt = base::TiltServo{.min_rad = -0.5, .max_rad = 0.5, .output = 6};
  ServoPacket packet;
  packet.pwm_us.fill(1000);
  packet.pwm_us[6] = 1500;
  EXPECT_FALSE(to_motor_command(packet, tri).armed);  // a centred servo arms nothing
  packet.pwm_us[3] = 1400;
  packet.pwm_us[6] = 1250;
  const MotorCommand command = to_motor_command(packet, tri);
  EXPECT_TRUE(command.armed);
  EXPECT_NEAR(command.values[3], 0.4, 1e-12);
  EXPECT_NEAR(command.values[6], -0.5, 1e-12);
}

TEST(ServoPacket, TurnsTheSurfacesOfAPlane) {
  base::Vehicle plane = rotors_on({2});
  plane.aero.emplace();
  for (const int output : {0, 1, 3}) plane.aero->surfaces.emplace_back().output = output;
  ServoPacket packet{.pwm_us = {1250, 1500, 1600, 0}};
  const MotorCommand command = to_motor_command(packet, plane);
  EXPECT_TRUE(command.armed);
  EXPECT_TRUE(command.values.head<4>().isApprox(Eigen::Vector4d(-0.5, 0, 0.6, 0), 1e-12));
}

TEST(JsonState, IsForwardRightDownAndNorthEastDown) {
  BodyState body;
  body.p_WB = {1, 2, 3};  // east, north, up
  body.v_WB = {0.1, 0.2, 0.3};
  body.w_WB_B = {0.4, 0.5, 0.6};
  body.q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0, 0, 0));  // level, nose north
  body.a_WB = {0, 1, 0};
  Environment air;
  air.gravity_W = {0, 0, -9.80665};
  const JsonState state = to_json_state(base::SimTime(microseconds(2500)), body, air);
  EXPECT_DOUBLE_EQ(state.timestamp_s, 0.0025);
  EXPECT_TRUE(state.p_N.isApprox(Eigen::Vector3d(2, 1, -3)));
  EXPECT_TRUE(state.v_N.isApprox(Eigen::Vector3d(0.2, 0.1, -0.3)));
  EXPECT_TRUE(state.gyro_D.isApprox(Eigen::Vector3d(0.4, -0.5, -0.6)));
  EXPECT_TRUE(state.accel_D.isApprox(Eigen::Vector3d(1, 0, -9.80665), 1e-12));
  EXPECT_NEAR(std::abs(state.q_ND.w()), 1, 1e-12);
}

TEST(JsonState, AtRestTheAccelerometerReadsMinusG) {
  BodyState body;
  Environment air;
  air.gravity_W = {0, 0, -9.80665};
  const JsonState state = to_json_state({}, body, air);
  EXPECT_TRUE(state.accel_D.isApprox(Eigen::Vector3d(0, 0, -9.80665), 1e-12));
}

TEST(JsonState, IsOneLineWithoutASpaceBetweenNewlines) {
  JsonState state;
  state.timestamp_s = 1.25;
  state.gyro_D = {0.5, -0.25, 0.125};
  state.accel_D = {0, 0, -9.5};
  state.p_N = {1, 2, -3};
  state.v_N = {4, 5, 6};
  const std::string text = to_text(state);
  EXPECT_EQ(text,
            "\n{\"timestamp\":1.250000000,\"imu\":{\"gyro\":[0.500000000,-0.250000000,0.125000000],"
            "\"accel_body\":[0.000000000,0.000000000,-9.500000000]},"
            "\"position\":[1.000000000,2.000000000,-3.000000000],"
            "\"velocity\":[4.000000000,5.000000000,6.000000000],"
            "\"quaternion\":[1.000000000,0.000000000,0.000000000,0.000000000]}\n");
  EXPECT_EQ(text.find(' '), std::string::npos);
  state.range_m = 1.5;
  EXPECT_NE(to_text(state).find(",\"rng_1\":1.500000000}\n"), std::string::npos);
  state.airspeed_m_s = to_airspeed_m_s(245, 1.225);
  EXPECT_NE(to_text(state).find(",\"airspeed\":20.000000000}\n"), std::string::npos);
  EXPECT_DOUBLE_EQ(to_airspeed_m_s(-245, 1.225), -20);
}

TEST(JsonState, NeverWritesWhatIsNoNumber) {
  JsonState state;
  state.v_N.x() = std::nan("");
  state.p_N.x() = HUGE_VAL;
  const std::string text = to_text(state);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_EQ(text.find("inf"), std::string::npos);
}

ServoPacket numbered(std::uint32_t count, std::uint16_t rate = 1200) {
  return {.frame_rate_hz = rate, .frame_count = count};
}

TEST(ServoClock, OneStepAPacketWhenTheStepFits) {
  const base::Duration step = std::chrono::nanoseconds(833'333);
  ServoClock clock(step);
  base::SimTime now{};
  for (std::uint32_t i = 0; i < 1200; ++i) {
    EXPECT_EQ(clock.on_packet(numbered(i), now), ServoClock::Kind::kNew);
    now += step;
    ASSERT_TRUE(clock.due(now)) << i;
    clock.answered();
  }
  EXPECT_EQ(clock.counts().packets, 1200U);
}

TEST(ServoClock, PeriodsThatAreNoMultipleOfTheStepAreRightOnAverage) {
  const base::Duration step = std::chrono::milliseconds(1);
  ServoClock clock(step);
  base::SimTime now{};
  for (std::uint32_t i = 0; i < 400; ++i) {
    clock.on_packet(numbered(i, 400), now);
    do now += step;
    while (!clock.due(now));
    clock.answered();
  }
  EXPECT_NEAR(base::to_seconds(now), 1.0, 0.002);
}

TEST(ServoClock, NoPeriodLastsATenthOfASecond) {
  ServoClock clock(std::chrono::milliseconds(1));
  clock.on_packet(numbered(0, 1), {});
  EXPECT_TRUE(clock.due(base::SimTime(std::chrono::milliseconds(99))));
  clock.answered();
  clock.on_packet(numbered(1, 0), base::SimTime(std::chrono::milliseconds(99)));
  EXPECT_TRUE(clock.due(base::SimTime(std::chrono::milliseconds(199))));
}

TEST(ServoClock, TellsRepeatsSkipsAndRestartsApart) {
  ServoClock clock(std::chrono::milliseconds(1));
  EXPECT_EQ(clock.on_packet(numbered(7), {}), ServoClock::Kind::kNew);
  EXPECT_EQ(clock.on_packet(numbered(7), {}), ServoClock::Kind::kPending);
  clock.answered();
  EXPECT_EQ(clock.on_packet(numbered(7), {}), ServoClock::Kind::kRepeated);
  EXPECT_EQ(clock.on_packet(numbered(10), {}), ServoClock::Kind::kNew);
  clock.answered();
  EXPECT_EQ(clock.on_packet(numbered(0), {}), ServoClock::Kind::kRestart);
  EXPECT_EQ(clock.counts().skipped, 2U);
  EXPECT_EQ(clock.counts().repeated, 2U);
  EXPECT_EQ(clock.counts().restarts, 1U);
}

}  // namespace
}  // namespace cas::sim
