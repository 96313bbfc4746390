// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/motion.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <optional>
#include <string>
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

struct CommandCase {
  const char* name;
  unsigned command;
  std::array<float, 7> params;
  Motion expected;
  Addressee to = kUnknown;
};

class CommandMotion : public testing::TestWithParam<CommandCase> {};

TEST_P(CommandMotion, IsTheMostThatTheCommandMayDo) {
  const CommandCase& test = GetParam();
  EXPECT_EQ(
      motion_of(VehicleCommand{.id = static_cast<MavCmd>(test.command), .params = test.params},
                test.to),
      test.expected);
}

INSTANTIATE_TEST_SUITE_P(
    Commands, CommandMotion,
    testing::Values(
        CommandCase{"Arm", 400, {1}, kSpins}, CommandCase{"ArmByANumber", 400, {0.3F}, kSpins},
        CommandCase{"ArmByNan", 400, {kNaN}, kSpins}, CommandCase{"Disarm", 400, {0}, kCuts},
        CommandCase{"Takeoff", 22, {}, kSpins}, CommandCase{"LocalTakeoff", 24, {}, kSpins},
        CommandCase{"VtolTakeoff", 84, {}, kSpins}, CommandCase{"MissionStart", 300, {}, kSpins},
        CommandCase{"MotorTest", 209, {1, 0, 5}, kSpins},
        CommandCase{"ActuatorTest", 310, {}, kSpins}, CommandCase{"Servo", 183, {1, 1900}, kSpins},
        CommandCase{"RepeatedServo", 184, {}, kSpins}, CommandCase{"Actuator", 187, {1}, kSpins},
        CommandCase{"EscCalibration", 241, {0, 0, 0, 0, 0, 0, 1}, kSpins},
        CommandCase{"GyroCalibration", 241, {1}, kNone},
        CommandCase{"AuxArm", 218, {153, 2}, kSpins},
        CommandCase{"AuxDisarm", 218, {153, 0}, kCuts},
        CommandCase{"AuxStopReleased", 218, {31, 0}, kSpins},
        CommandCase{"AuxOff", 218, {9, 0}, kMoves}, CommandCase{"EngineStart", 223, {1}, kSpins},
        CommandCase{"Termination", 185, {1}, kCuts},
        CommandCase{"TerminationTakenBack", 185, {0}, kSpins},
        CommandCase{"TerminationTakenBackByAFraction", 185, {0.3F}, kSpins},
        CommandCase{"RebootInFlight", 246, {1}, kMoves, kPx4Armed},
        CommandCase{"RebootAtRest", 246, {1}, kNone, kPx4},
        CommandCase{"RebootOfAnUnknownOne", 246, {1}, kMoves},
        CommandCase{"NoReboot", 246, {0, 1}, kNone, kPx4Armed},
        CommandCase{"Reposition", 192, {}, kMoves}, CommandCase{"Orbit", 34, {}, kMoves},
        CommandCase{"Waypoint", 16, {}, kMoves}, CommandCase{"Speed", 178, {}, kMoves},
        CommandCase{"Pause", 193, {0}, kStops}, CommandCase{"Continue", 193, {1}, kMoves},
        CommandCase{"GotoHoldHere", 252, {0, 2}, kStops},
        CommandCase{"GotoHoldThere", 252, {0, 3}, kMoves}, CommandCase{"Land", 21, {}, kStops},
        CommandCase{"Return", 20, {}, kStops}, CommandCase{"Loiter", 17, {}, kStops},
        CommandCase{"StandardLand", 262, {7}, kStops},
        CommandCase{"StandardMission", 262, {6}, kMoves},
        CommandCase{"ParametersReset", 245, {2}, kMoves},
        CommandCase{"ParametersStored", 245, {1}, kNone},
        CommandCase{"RequestMessage", 512, {242}, kNone},
        CommandCase{"SafetyOff", 5300, {1}, kSpins}, CommandCase{"SafetyOn", 5300, {0}, kCuts},
        CommandCase{"SoloPauses", 42003, {}, kStops},
        CommandCase{"SoloPowersOff", 42000, {}, kMoves},
        CommandCase{"UnknownOne", 31010, {}, kMoves}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Modes, CommandMotion,
    testing::Values(
        CommandCase{"Px4Hold", 176, {kCustom, 4, 3}, kStops, kPx4},
        CommandCase{"Px4Termination", 176, {kCustom, 10}, kCuts, kPx4Armed},
        CommandCase{"Px4HoldThatKeepsArmed", 176, {kCustomArmed, 4, 3}, kStops, kPx4Armed},
        CommandCase{"Px4HoldThatArms", 176, {kCustomArmed, 4, 3}, kSpins, kPx4},
        CommandCase{"Px4Mission", 176, {kCustom, 4, 4}, kMoves, kPx4Armed},
        CommandCase{"CopterBrake", 176, {kCustom, 17}, kStops, kCopterArmed},
        CommandCase{"CopterGuided", 176, {kCustom, 4, 3}, kMoves, kCopterArmed},
        CommandCase{"PlaneReturns", 176, {kCustom, 11}, kStops, kPlaneArmed},
        CommandCase{"PlaneFliesByWire", 176, {kCustom, 5}, kMoves, kPlaneArmed},
        CommandCase{"OfAnUnknownOne", 176, {kCustom, 4, 3}, kMoves},
        CommandCase{"OfAnUnknownOneWithTheArmedFlag", 176, {kCustomArmed, 4, 3}, kSpins},
        CommandCase{"WithoutItsFlag", 176, {0, 4, 3}, kMoves, kPx4Armed},
        CommandCase{"NoSetOfFlags", 176, {1e9F, 4, 3}, kSpins, kPx4Armed},
        CommandCase{"NoNumber", 176, {kCustom, kNaN, 3}, kMoves, kPx4Armed}),
    [](const auto& test) { return test.param.name; });

/// A packet with nothing but its message and payload.
PacketView bare(std::uint32_t message_id, std::span<const std::uint8_t> payload) {
  PacketView packet;
  packet.message_id = message_id;
  packet.source = {255, 190};
  packet.payload = payload;
  return packet;
}

template <class Message>
Motion motion_of_message(const Message& message, const Addressee& to = kUnknown) {
  std::array<std::uint8_t, Message::kMaxLength> payload{};
  message.pack(payload.data());
  return motion_of(bare(Message::kId, payload), to);
}

TEST(Motion, OfACommandIsTheSameInBothForms) {
  mavlink::common::CommandLong in_long;
  in_long.command = MavCmd::kComponentArmDisarm;
  in_long.param1 = 1;
  EXPECT_EQ(motion_of_message(in_long), kSpins);
  mavlink::common::CommandInt in_int;
  in_int.command = MavCmd::kComponentArmDisarm;
  EXPECT_EQ(motion_of_message(in_int), kCuts);
  in_int.param1 = 1;
  EXPECT_EQ(motion_of_message(in_int), kSpins);
}

TEST(Motion, OfSetModeDependsOnItsArmedFlag) {
  mavlink::common::SetMode set;
  set.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed;
  set.custom_mode = 3U << 24U | 4U << 16U;
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
