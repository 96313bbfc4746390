// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/motion.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string_view>
#include <vector>

#include "mavlink/common/command_int.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/file_transfer_protocol.hpp"
#include "mavlink/common/param_set.hpp"
#include "mavlink/common/set_mode.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::mav::services {
namespace {

using mavlink::common::MavCmd;
using mavlink::common::MavModeFlag;
using mavlink::common::MavType;
using enum Motion;

constexpr Addressee kUnknown;
constexpr Addressee kPx4{Autopilot::kPx4, MavType::kQuadrotor, false};
constexpr Addressee kPx4Armed{Autopilot::kPx4, MavType::kQuadrotor, true};
constexpr Addressee kCopterArmed{Autopilot::kArduPilot, MavType::kQuadrotor, true};
constexpr Addressee kPlaneArmed{Autopilot::kArduPilot, MavType::kFixedWing, true};
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kCustom = 1;
constexpr float kCustomArmed = 129;

TEST(CommandMotion, IsTheMostThatTheCommandMayDo) {
  struct CommandCase {
    const char* name;
    unsigned command;
    std::array<float, 7> params;
    Motion expected;
    Addressee to = kUnknown;
  };
  const CommandCase rows[] = {
      {"Arm", 400, {1}, kSpins},
      {"ArmByANumber", 400, {0.3F}, kSpins},
      {"ArmByNan", 400, {kNaN}, kSpins},
      {"Disarm", 400, {0}, kCuts},
      {"Takeoff", 22, {}, kSpins},
      {"LocalTakeoff", 24, {}, kSpins},
      {"VtolTakeoff", 84, {}, kSpins},
      {"MissionStart", 300, {}, kSpins},
      {"MotorTest", 209, {1, 0, 5}, kSpins},
      {"ActuatorTest", 310, {}, kSpins},
      {"Servo", 183, {1, 1900}, kSpins},
      {"RepeatedServo", 184, {}, kSpins},
      {"Actuator", 187, {1}, kSpins},
      {"EscCalibration", 241, {0, 0, 0, 0, 0, 0, 1}, kSpins},
      {"GyroCalibration", 241, {1}, kNone},
      {"AuxArm", 218, {153, 2}, kSpins},
      {"AuxDisarm", 218, {153, 0}, kCuts},
      {"AuxStopReleased", 218, {31, 0}, kSpins},
      {"AuxOff", 218, {9, 0}, kMoves},
      {"EngineStart", 223, {1}, kSpins},
      {"Termination", 185, {1}, kCuts},
      {"TerminationTakenBack", 185, {0}, kSpins},
      {"TerminationTakenBackByAFraction", 185, {0.3F}, kSpins},
      {"RebootInFlight", 246, {1}, kMoves, kPx4Armed},
      {"RebootAtRest", 246, {1}, kNone, kPx4},
      {"RebootOfAnUnknownOne", 246, {1}, kMoves},
      {"NoReboot", 246, {0, 1}, kNone, kPx4Armed},
      {"Reposition", 192, {}, kMoves},
      {"Orbit", 34, {}, kMoves},
      {"Waypoint", 16, {}, kMoves},
      {"Speed", 178, {}, kMoves},
      {"Pause", 193, {0}, kStops},
      {"Continue", 193, {1}, kMoves},
      {"GotoHoldHere", 252, {0, 2}, kStops},
      {"GotoHoldThere", 252, {0, 3}, kMoves},
      {"Land", 21, {}, kStops},
      {"Return", 20, {}, kStops},
      {"Loiter", 17, {}, kStops},
      {"StandardLand", 262, {7}, kStops},
      {"StandardMission", 262, {6}, kMoves},
      {"ParametersReset", 245, {2}, kMoves},
      {"ParametersStored", 245, {1}, kNone},
      {"RequestMessage", 512, {242}, kNone},
      {"SafetyOff", 5300, {1}, kSpins},
      {"SafetyOn", 5300, {0}, kCuts},
      {"SoloPauses", 42003, {}, kStops},
      {"SoloPowersOff", 42000, {}, kMoves},
      {"UnknownOne", 31010, {}, kMoves},
      {"Px4Hold", 176, {kCustom, 4, 3}, kStops, kPx4},
      {"Px4Termination", 176, {kCustom, 10}, kCuts, kPx4Armed},
      {"Px4HoldThatKeepsArmed", 176, {kCustomArmed, 4, 3}, kStops, kPx4Armed},
      {"Px4HoldThatArms", 176, {kCustomArmed, 4, 3}, kSpins, kPx4},
      {"Px4Mission", 176, {kCustom, 4, 4}, kMoves, kPx4Armed},
      {"CopterBrake", 176, {kCustom, 17}, kStops, kCopterArmed},
      {"CopterGuided", 176, {kCustom, 4, 3}, kMoves, kCopterArmed},
      {"PlaneReturns", 176, {kCustom, 11}, kStops, kPlaneArmed},
      {"PlaneFliesByWire", 176, {kCustom, 5}, kMoves, kPlaneArmed},
      {"OfAnUnknownOne", 176, {kCustom, 4, 3}, kMoves},
      {"OfAnUnknownOneWithTheArmedFlag", 176, {kCustomArmed, 4, 3}, kSpins},
      {"WithoutItsFlag", 176, {0, 4, 3}, kMoves, kPx4Armed},
      {"NoSetOfFlags", 176, {1e9F, 4, 3}, kSpins, kPx4Armed},
      {"NoNumber", 176, {kCustom, kNaN, 3}, kMoves, kPx4Armed}};
  for (const auto& test : rows) {
    SCOPED_TRACE(test.name);
    EXPECT_EQ(
        motion_of(VehicleCommand{.id = static_cast<MavCmd>(test.command), .params = test.params},
                  test.to),
        test.expected);
  }
}

/// A packet with nothing but its message and payload.
PacketView bare(std::uint32_t message_id, std::span<const std::uint8_t> payload) {
  return {.source = {255, 190}, .message_id = message_id, .payload = payload};
}

template <class Message>
Motion motion_of_message(const Message& message, const Addressee& to = kUnknown) {
  std::array<std::uint8_t, Message::kMaxLength> payload{};
  message.pack(payload.data());
  return motion_of(bare(Message::kId, payload), to);
}

TEST(Motion, OfACommandIsTheSameInBothForms) {
  mavlink::common::CommandLong in_long{.command = MavCmd::kComponentArmDisarm, .param1 = 1};
  EXPECT_EQ(motion_of_message(in_long), kSpins);
  mavlink::common::CommandInt in_int{.command = MavCmd::kComponentArmDisarm};
  EXPECT_EQ(motion_of_message(in_int), kCuts);
  in_int.param1 = 1;
  EXPECT_EQ(motion_of_message(in_int), kSpins);
}

TEST(Motion, OfSetModeDependsOnItsArmedFlag) {
  mavlink::common::SetMode set{
      .base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed,
      .custom_mode = 3U << 24U | 4U << 16U};
  EXPECT_EQ(motion_of_message(set, kPx4), kSpins);
  EXPECT_EQ(motion_of_message(set, kPx4Armed), kStops);
  set.custom_mode = 4U << 16U;
  EXPECT_EQ(motion_of_message(set, kPx4Armed), kMoves);
}

TEST(Motion, OfAParameterGoesByItsName) {
  for (const char* arms :
       {"COM_ARM_WO_GPS", "ARMING_CHECK", "arming_check", "CBRK_SUPPLY_CHK", "PWM_MAIN_DIS1",
        "MOT_SPIN_ARM", "SERVO1_FUNCTION", "RC7_OPTION", "CH7_OPT", "ESC_CALIBRATION",
        "AUTO_OPTIONS", "SYS_HAS_MAG", "COM_RC_IN_MODE", "RELAY1_FUNCTION"}) {
    EXPECT_EQ(motion_of_parameter(arms), kSpins) << arms;
  }
  EXPECT_EQ(motion_of_parameter("MC_ROLLRATE_P"), kMoves);
  mavlink::common::ParamSet set;
  mav::set_text(set.param_id, "COM_ARM_WO_GPS");
  EXPECT_EQ(motion_of_message(set), kSpins);
  std::vector<std::uint8_t> ext{1, 1};
  for (const char c : std::string_view("CBRK_IO_SAFETY")) {
    ext.push_back(static_cast<std::uint8_t>(c));
  }
  EXPECT_EQ(motion_of(bare(323, ext), kUnknown), kSpins);
}

TEST(Motion, TheWayIntoHilIsToldFromOtherParametersOfOutputs) {
  EXPECT_TRUE(leads_into_hil("SYS_HITL", 1));
  EXPECT_TRUE(leads_into_hil("HIL_ACT_FUNC1", 101));
  EXPECT_TRUE(leads_into_hil("SYS_AUTOSTART", 1001));
  EXPECT_FALSE(leads_into_hil("SYS_AUTOSTART", 4001));
  EXPECT_FALSE(leads_into_hil("CBRK_SUPPLY_CHK", 894281));
  EXPECT_FALSE(leads_into_hil("PWM_MAIN_FUNC1", 101));
}

TEST(Motion, OfAFileTransferIsNoneWhereItReads) {
  mavlink::common::FileTransferProtocol message;
  message.payload[3] = 4;  // OpenFileRO
  EXPECT_EQ(motion_of_message(message), kNone);
  message.payload[3] = 7;  // WriteFile
  EXPECT_EQ(motion_of_message(message), kMoves);
  message.payload[3] = 128;  // an answer
  EXPECT_EQ(motion_of_message(message), kNone);
}

TEST(Motion, OfOtherMessagesGoesByTheirNumber) {
  for (const std::uint32_t id : {69, 70, 126, 139, 223, 224, 292, 420, 421}) {
    EXPECT_EQ(motion_of(bare(id, {}), kUnknown), kSpins) << id;
  }
  for (const std::uint32_t id : {41, 44, 73, 82, 84, 86, 256, 354}) {
    EXPECT_EQ(motion_of(bare(id, {}), kUnknown), kMoves) << id;
  }
  for (const std::uint32_t id : {33, 107, 147, 232, 331, 180123}) {
    EXPECT_EQ(motion_of(bare(id, {}), kUnknown), kMisleads) << id;
  }
  for (const std::uint32_t id : {0, 1, 30, 65, 77, 253}) {
    EXPECT_EQ(motion_of(bare(id, {}), kUnknown), kNone) << id;
  }
  PacketView sticks = bare(65, {});
  sticks.source.component = 250;
  EXPECT_EQ(motion_of(sticks, kUnknown), kSpins);
}

}  // namespace
}  // namespace cas::mav::services
