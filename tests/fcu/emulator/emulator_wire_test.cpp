// SPDX-License-Identifier: BSD-3-Clause
// fcu_emulator's messages to a ground station that only listens, requests and pings.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>

#include "mavlink/common/attitude.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/available_modes.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/message_interval.hpp"
#include "mavlink/common/param_set.hpp"
#include "mavlink/common/ping.hpp"
#include "mavlink/common/protocol_version.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink/common/system_time.hpp"
#include "mavlink/common/timesync.hpp"
#include "mavlink_gen/runtime/message.hpp"
#include "tests/fcu/support/emulator_fixture.hpp"

namespace cas::fcu {
namespace {

using namespace mavlink::common;  // NOLINT
using test::EmulatorFixture;

class Wire : public testing::Test {
 protected:
  template <class Message>
  MavResult request() {
    return emulator_.result(MavCmd::kRequestMessage, {static_cast<float>(Message::kId)}).value();
  }
  EmulatorFixture emulator_;
};

TEST_F(Wire, HeartbeatIsThatOfAPx4QuadrotorInHil) {
  const auto beat = emulator_.next<Heartbeat>();
  ASSERT_TRUE(beat);
  EXPECT_EQ(emulator_.source(), (mav::Source{1, 1}));
  EXPECT_EQ(beat->type, MavType::kQuadrotor);
  EXPECT_EQ(beat->autopilot, MavAutopilot::kPx4);
  EXPECT_TRUE(has(beat->base_mode, MavModeFlag::kCustomModeEnabled));
  EXPECT_TRUE(has(beat->base_mode, MavModeFlag::kHilEnabled));
  EXPECT_FALSE(has(beat->base_mode, MavModeFlag::kSafetyArmed));
  EXPECT_EQ(beat->custom_mode, 4U << 16U | 3U << 24U);  // AUTO, LOITER
  EXPECT_EQ(beat->system_status, MavState::kBoot);      // no sensor data yet
  EXPECT_EQ(beat->mavlink_version, 3);
}

TEST_F(Wire, HeartbeatComesWithoutSensors) {
  const auto first = emulator_.next<Heartbeat>();
  const auto second = emulator_.next<Heartbeat>();
  EXPECT_TRUE(first && second);
}

TEST_F(Wire, HeartbeatSaysStandbyWhenTheEstimateStands) {
  emulator_.settle();
  EXPECT_TRUE(emulator_.next<Heartbeat>(
      [](const Heartbeat& m) { return m.system_status == MavState::kStandby; }));
}

TEST_F(Wire, VersionsCapabilitiesAndModesAreToldOnRequest) {
  using C = MavProtocolCapability;
  emulator_.send(
      emulator_.command(MavCmd::kRequestMessage, {static_cast<float>(AutopilotVersion::kId)}));
  const auto version = emulator_.next<AutopilotVersion>();
  ASSERT_TRUE(version);
  for (const C c : {C::kMissionInt, C::kCommandInt, C::kParamEncodeBytewise, C::kMavlink2,
                    C::kSetPositionTargetLocalNed, C::kSetAttitudeTarget}) {
    EXPECT_TRUE(has(version->capabilities, c)) << static_cast<std::uint64_t>(c);
  }
  EXPECT_FALSE(has(version->capabilities, C::kMissionFence));
  EXPECT_FALSE(has(version->capabilities, C::kMissionRally));
  EXPECT_FALSE(has(version->capabilities, C::kParamEncodeCCast));
  EXPECT_NE(version->flight_sw_version, 0U);
  EXPECT_NE(version->uid, 0U);

  emulator_.send(emulator_.command(MavCmd::kRequestAutopilotCapabilities, {1}));
  EXPECT_TRUE(emulator_.next<AutopilotVersion>());

  emulator_.send(emulator_.command(MavCmd::kRequestProtocolVersion, {1}));
  const auto protocol = emulator_.next<ProtocolVersion>();
  ASSERT_TRUE(protocol);
  EXPECT_EQ(protocol->max_version, 200);
  EXPECT_EQ(protocol->min_version, 100);

  emulator_.send(
      emulator_.command(MavCmd::kRequestMessage, {static_cast<float>(AvailableModes::kId)}));
  std::vector<std::uint32_t> modes;
  for (int i = 0; i < 9; ++i) {
    const auto mode = emulator_.next<AvailableModes>();
    ASSERT_TRUE(mode);
    EXPECT_EQ(mode->number_modes, 9);
    EXPECT_EQ(mode->mode_index, i + 1);
    EXPECT_FALSE(mav::text(mode->mode_name).empty());
    modes.push_back(mode->custom_mode);
  }
  EXPECT_NE(std::find(modes.begin(), modes.end(), 6U << 16U), modes.end());  // OFFBOARD
}

TEST_F(Wire, AMessageThatHasNothingToSayYetIsRejectedForNow) {
  EXPECT_EQ(request<HomePosition>(), MavResult::kTemporarilyRejected);
  emulator_.settle();
  EXPECT_EQ(request<HomePosition>(), MavResult::kAccepted);
}

TEST_F(Wire, MessagesThatAreNotOursAreUnsupported) {
  for (const float id : {259.0F, 280.0F, 397.0F, 395.0F, 12345.0F}) {
    EXPECT_EQ(emulator_.result(MavCmd::kRequestMessage, {id}), MavResult::kUnsupported) << id;
    EXPECT_EQ(emulator_.result(MavCmd::kSetMessageInterval, {id, 1e5F}), MavResult::kUnsupported)
        << id;
  }
}

TEST_F(Wire, IntervalsAreSetToldAndGivenBack) {
  const auto id = static_cast<float>(SystemTime::kId);
  const auto interval = [&] {
    emulator_.send(emulator_.command(MavCmd::kGetMessageInterval, {id}));
    return emulator_.next<MessageInterval>()->interval_us;
  };
  const int usual = interval();
  EXPECT_EQ(usual, 1'000'000);
  EXPECT_EQ(emulator_.result(MavCmd::kSetMessageInterval, {id, 20'000}), MavResult::kAccepted);
  EXPECT_EQ(interval(), 20'000);
  // By the stream's own clock, whatever the machine does to ours.
  std::vector<double> gaps_ms;
  auto last = emulator_.next<SystemTime>()->time_boot_ms;
  for (int i = 0; i < 15; ++i) {
    const auto now = emulator_.next<SystemTime>()->time_boot_ms;
    gaps_ms.push_back(static_cast<double>(now - last));
    last = now;
  }
  std::sort(gaps_ms.begin(), gaps_ms.end());
  EXPECT_NEAR(gaps_ms[7], 20, 5);
  EXPECT_EQ(emulator_.result(MavCmd::kSetMessageInterval, {id, -1}), MavResult::kAccepted);
  EXPECT_EQ(interval(), -1);
  EXPECT_EQ(emulator_.result(MavCmd::kSetMessageInterval, {id, 0}), MavResult::kAccepted);
  EXPECT_EQ(interval(), usual);
}

TEST_F(Wire, TimesyncIsAnsweredWithOurTimeAndTheirs) {
  Timesync request;
  request.ts1 = 123'456'789;
  emulator_.send(request);
  const auto first = emulator_.next<Timesync>();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->ts1, 123'456'789);
  EXPECT_GT(first->tc1, 0);
  request.ts1 = 5;
  emulator_.send(request);
  const auto second = emulator_.next<Timesync>();
  ASSERT_TRUE(second);
  EXPECT_GT(second->tc1, first->tc1);
  // An answer of another node is no request.
  Timesync answer;
  answer.tc1 = 9;
  emulator_.send(answer);
  EXPECT_TRUE(emulator_.until_ping<Timesync>().empty());
}

TEST_F(Wire, PingIsAnsweredToItsSender) {
  Ping ping;
  ping.time_usec = 77;
  ping.seq = 4000;
  emulator_.send(ping, 2, {42, 7});
  const auto answer = emulator_.next<Ping>();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->time_usec, 77U);
  EXPECT_EQ(answer->seq, 4000U);
  EXPECT_EQ(answer->target_system, 42);
  EXPECT_EQ(answer->target_component, 7);
  // A PING with a target is an answer: it is not answered again.
  ping.target_system = 1;
  ping.target_component = 1;
  emulator_.send(ping);
  EXPECT_TRUE(emulator_.until_ping<Ping>().empty());
}

TEST_F(Wire, Mavlink1IsAnsweredWithMavlink1) {
  emulator_.send(Ping{1, 2, 0, 0}, 1);
  ASSERT_TRUE(emulator_.next<Ping>());
  EXPECT_EQ(emulator_.version(), 1);
  emulator_.send(emulator_.command(MavCmd::kRequestMessage, {static_cast<float>(SysStatus::kId)}),
                 1);
  ASSERT_TRUE(emulator_.next<CommandAck>());
  EXPECT_EQ(emulator_.version(), 1);
  emulator_.send(Ping{1, 3, 0, 0}, 2);
  ASSERT_TRUE(emulator_.next<Ping>());
  EXPECT_EQ(emulator_.version(), 2);
}

TEST_F(Wire, WhatIsForOthersIsLeftAlone) {
  CommandLong m = emulator_.command(MavCmd::kRequestMessage, {static_cast<float>(SysStatus::kId)});
  m.target_system = 2;
  emulator_.send(m);
  m.target_system = 1;
  m.target_component = 100;  // a camera
  emulator_.send(m);
  EXPECT_TRUE(emulator_.until_ping<CommandAck>().empty());
  m.target_system = 0;  // broadcast
  m.target_component = 0;
  emulator_.send(m);
  EXPECT_FALSE(emulator_.until_ping<CommandAck>().empty());
}

/// Answers to one second of sensors, in chunks that no buffer between the programs is too small
/// for.
template <class Answer>
std::vector<Answer> answers_of_a_second(EmulatorFixture& emulator) {
  std::vector<Answer> all;
  for (int chunk = 0; chunk < 10; ++chunk) {
    emulator.stand_still(0.1);
    for (const Answer& answer : emulator.until_ping<Answer>()) all.push_back(answer);
  }
  return all;
}

TEST_F(Wire, AnswersComeAt400HzOfTheSensorsClockWithItsStamps) {
  emulator_.stand_still(0.1);
  emulator_.until_ping<HilControls>();
  const auto answers = answers_of_a_second<HilControls>(emulator_);
  ASSERT_NEAR(static_cast<double>(answers.size()), 400, 1);
  for (std::size_t i = 1; i < answers.size(); ++i) {
    const std::uint64_t gap_us = answers[i].time_usec - answers[i - 1].time_usec;
    EXPECT_TRUE(gap_us == 2000 || gap_us == 4000) << gap_us;  // a sample's stamp, 2 ms apart
    EXPECT_EQ(answers[i].throttle, 0);
    EXPECT_EQ(static_cast<int>(answers[i].mode), 32);  // HIL, disarmed
  }
}

TEST_F(Wire, AnswersAreMotorOutputsByParameter) {
  ParamSet by_motor;
  by_motor.target_system = 1;
  by_motor.target_component = 1;
  mav::set_text(by_motor.param_id, "CAS_HIL_ACT");
  by_motor.param_value = std::bit_cast<float>(std::int32_t{1});
  by_motor.param_type = MavParamType::kInt32;
  emulator_.send(by_motor);
  emulator_.until_ping<HilControls>();
  const auto answers = answers_of_a_second<HilActuatorControls>(emulator_);
  ASSERT_NEAR(static_cast<double>(answers.size()), 400, 1);
  for (const float output : answers.back().controls) EXPECT_EQ(output, 0);
  EXPECT_EQ(static_cast<int>(answers.back().mode), 32);
  EXPECT_EQ(answers.back().time_usec % 2000, 0U);
}

TEST_F(Wire, GarbageIsSurvivedAndCounted) {
  std::vector<std::uint8_t> noise(20'000);
  base::NormalRandom random(3);
  for (auto& byte : noise) byte = static_cast<std::uint8_t>(256 * random.uniform());
  emulator_.send_bytes(noise);
  // A whole packet with a wrong checksum, and the beginning of one that never ends.
  std::array<std::uint8_t, mav::kMaxPacketBytes> buffer{};
  const std::size_t size = mav::encode(Ping{1, 2, 0, 0}, {255, 190}, 0, buffer);
  buffer[12] ^= 0x40U;
  emulator_.send_bytes(std::span(buffer).first(size));
  emulator_.send_bytes(std::span(buffer).first(9));
  // The line may take a few whole packets to be in step again.
  bool answered = false;
  for (std::uint32_t i = 0; i < 200 && !answered; ++i) {
    emulator_.send(Ping{0, 70'000 + i, 0, 0});
    emulator_.read();
    answered = i >= 20 && emulator_.next<Ping>().has_value();
  }
  EXPECT_TRUE(answered);
  EXPECT_GE(emulator_.call("fcu.stats")["crc_errors"].get<int>(), 1);
  EXPECT_EQ(emulator_.garbage(), 0U);
}

}  // namespace
}  // namespace cas::fcu
