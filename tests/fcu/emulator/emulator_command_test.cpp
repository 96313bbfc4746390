// SPDX-License-Identifier: BSD-3-Clause
// Commands to fcu_emulator over its pseudo-terminal, and the results it acknowledges.
#include <gtest/gtest.h>

#include "base/earth/geodesy.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/command_int.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/set_mode.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink_gen/runtime/message.hpp"
#include "tests/fcu/support/emulator_fixture.hpp"

namespace cas::fcu {
namespace {

using namespace mavlink::common;  // NOLINT
using test::EmulatorFixture;

class Commands : public testing::Test {
 protected:
  /// A STATUSTEXT put together from its pieces.
  std::string text() {
    std::string whole;
    for (int piece = 0;; ++piece) {
      const auto m = emulator_.next<Statustext>();
      if (!m) return "nothing said";
      whole += mav::text(m->text);
      const bool last = m->id == 0 || mav::text(m->text).size() < m->text.size();
      if (last) return whole;
    }
  }
  std::optional<MavResult> result(const CommandInt& m) {
    emulator_.send(m);
    const auto ack =
        emulator_.next<CommandAck>([&](const auto& a) { return a.command == m.command; });
    return ack ? std::optional(ack->result) : std::nullopt;
  }
  EmulatorFixture emulator_;
};

TEST_F(Commands, AcknowledgementsNameTheirCommandAndSender) {
  emulator_.send(emulator_.command(MavCmd::kRequestAutopilotCapabilities, {1}), 2, {42, 7});
  const auto ack = emulator_.next<CommandAck>();
  ASSERT_TRUE(ack);
  EXPECT_EQ(ack->command, MavCmd::kRequestAutopilotCapabilities);
  EXPECT_EQ(ack->result, MavResult::kAccepted);
  EXPECT_EQ(ack->target_system, 42);
  EXPECT_EQ(ack->target_component, 7);
}

struct Answer {
  const char* name;
  MavCmd command;
  std::array<float, 7> params;
  MavResult result;
};

class CommandResult : public Commands, public testing::WithParamInterface<Answer> {};

TEST_P(CommandResult, IsTheRightOne) {
  const Answer& answer = GetParam();
  EXPECT_EQ(emulator_.result(answer.command, answer.params), answer.result);
}

INSTANTIATE_TEST_SUITE_P(
    WithoutSensors, CommandResult,
    testing::Values(
        Answer{"UnknownIsUnsupported", static_cast<MavCmd>(31999), {}, MavResult::kUnsupported},
        Answer{"UnknownModeIsUnsupported", MavCmd::kDoSetMode, {1, 5, 0}, MavResult::kUnsupported},
        Answer{"HalfArmedIsDenied", MavCmd::kComponentArmDisarm, {0.5F}, MavResult::kDenied},
        Answer{"ShutdownIsDenied", MavCmd::kPreflightRebootShutdown, {2}, MavResult::kDenied},
        Answer{"TinyOrbitIsDenied", MavCmd::kDoOrbit, {0.1F, 1}, MavResult::kDenied},
        Answer{"MissingMissionItemIsDenied", MavCmd::kMissionStart, {3}, MavResult::kDenied},
        Answer{"ArmingIsRejectedForNow",
               MavCmd::kComponentArmDisarm,
               {1},
               MavResult::kTemporarilyRejected},
        Answer{"RepositionOnTheGroundIsRejectedForNow",
               MavCmd::kDoReposition,
               {-1, 1},
               MavResult::kTemporarilyRejected},
        Answer{"OffboardWithoutSetPointsIsRejectedForNow",
               MavCmd::kDoSetMode,
               {1, 6, 0},
               MavResult::kTemporarilyRejected},
        Answer{"CompassCalibrationIsUnsupported",
               MavCmd::kPreflightCalibration,
               {0, 1},
               MavResult::kUnsupported},
        Answer{"HoldIsAccepted", MavCmd::kNavLoiterUnlim, {}, MavResult::kAccepted}),
    [](const auto& test) { return test.param.name; });

TEST_F(Commands, ArmingIsRefusedWithAReasonAndAcceptedWhenAllIsThere) {
  EXPECT_EQ(emulator_.result(MavCmd::kComponentArmDisarm, {1}), MavResult::kTemporarilyRejected);
  EXPECT_EQ(text(), "Arming denied: no accelerometer and gyro data");
  // Attitude is there after a second; the position still settles.
  emulator_.stand_still(1.5);
  EXPECT_EQ(emulator_.result(MavCmd::kComponentArmDisarm, {1}), MavResult::kTemporarilyRejected);
  EXPECT_EQ(text(), "Arming denied: waiting for the position estimate to settle");
  emulator_.settle();
  // As a ground station does: again, while the answer is "not now".
  std::optional<MavResult> result;
  const bool armed = cas::test::wait_until([&] {
    emulator_.stand_still(0.05);
    result = emulator_.result(MavCmd::kComponentArmDisarm, {1});
    return result != MavResult::kTemporarilyRejected;
  });
  EXPECT_TRUE(armed);
  EXPECT_EQ(result, MavResult::kAccepted);
}

TEST_F(Commands, GyroCalibrationIsInProgressUntilTheBiasIsKnown) {
  emulator_.settle();
  ASSERT_EQ(emulator_.result(MavCmd::kPreflightCalibration, {1}), MavResult::kInProgress);
  EXPECT_EQ(emulator_.result(MavCmd::kPreflightCalibration, {1}), MavResult::kTemporarilyRejected);
  std::optional<CommandAck> last;
  EXPECT_TRUE(cas::test::wait_until([&] {
    emulator_.stand_still(0.5);
    last = emulator_.next<CommandAck>({}, {}, std::chrono::milliseconds(20));
    return last && last->result == MavResult::kAccepted;
  }));
  EXPECT_EQ(last->command, MavCmd::kPreflightCalibration);
  EXPECT_EQ(last->progress, 100);
}

TEST_F(Commands, GyroCalibrationIsCancelledByNothingAsked) {
  ASSERT_EQ(emulator_.result(MavCmd::kPreflightCalibration, {1}), MavResult::kInProgress);
  EXPECT_EQ(emulator_.result(MavCmd::kPreflightCalibration), MavResult::kAccepted);
  EXPECT_TRUE(emulator_.next<CommandAck>([](const auto& m) {
    return m.command == MavCmd::kPreflightCalibration && m.result == MavResult::kCancelled;
  }));
}

TEST_F(Commands, ARepetitionGetsTheSameAnswerAndDoesNothingTwice) {
  emulator_.settle();
  CommandLong m = emulator_.command(MavCmd::kPreflightCalibration, {1});
  const auto answer = [&] {
    emulator_.send(m);
    return emulator_.next<CommandAck>([&](const auto& a) { return a.command == m.command; })
        ->result;
  };
  ASSERT_EQ(answer(), MavResult::kInProgress);
  m.confirmation = 1;  // the station did not hear it
  EXPECT_EQ(answer(), MavResult::kInProgress);
  m.confirmation = 0;  // a new wish
  EXPECT_EQ(answer(), MavResult::kTemporarilyRejected);
}

TEST_F(Commands, IntegersCarryThePlaceExactly) {
  emulator_.settle();
  const base::Geodetic place = base::LocalProjection(emulator_.home()).to_geodetic({30, -20, -1});
  CommandInt m;
  m.target_system = 1;
  m.target_component = 1;
  m.command = MavCmd::kDoSetHome;
  m.frame = MavFrame::kGlobalInt;
  m.x = static_cast<std::int32_t>(std::llround(place.lat_deg * 1e7));
  m.y = static_cast<std::int32_t>(std::llround(place.lon_deg * 1e7));
  m.z = 489;
  ASSERT_EQ(result(m), MavResult::kAccepted);
  emulator_.send(
      emulator_.command(MavCmd::kRequestMessage, {static_cast<float>(HomePosition::kId)}));
  const auto home = emulator_.next<HomePosition>();
  ASSERT_TRUE(home);
  EXPECT_NEAR(home->latitude, m.x, 1);
  EXPECT_NEAR(home->longitude, m.y, 1);
  EXPECT_NEAR(home->altitude, 489'000, 1);
  m.frame = static_cast<MavFrame>(20);
  EXPECT_EQ(result(m), MavResult::kCommandUnsupportedMavFrame);
  m.command = static_cast<MavCmd>(31999);
  EXPECT_EQ(result(m), MavResult::kUnsupported);
}

TEST_F(Commands, SetModeAndDoSetModeChangeTheModeInTheHeartbeat) {
  SetMode m;
  m.target_system = 1;
  m.base_mode = MavModeFlag::kCustomModeEnabled;
  m.custom_mode = 4U << 16U | 6U << 24U;  // AUTO, LAND
  emulator_.send(m);
  const auto shows = [&](std::uint32_t custom) {
    return emulator_.next<Heartbeat>([=](const auto& beat) { return beat.custom_mode == custom; })
        .has_value();
  };
  EXPECT_TRUE(shows(4U << 16U | 6U << 24U));
  ASSERT_EQ(emulator_.result(MavCmd::kDoSetMode, {1, 4, 3}), MavResult::kAccepted);
  EXPECT_TRUE(shows(4U << 16U | 3U << 24U));
  ASSERT_EQ(emulator_.result(MavCmd::kDoSetMode, {1, 3, 0}), MavResult::kAccepted);
  EXPECT_TRUE(shows(3U << 16U));
}

TEST_F(Commands, PrearmChecksSayWhatIsMissing) {
  ASSERT_EQ(emulator_.result(MavCmd::kRunPrearmChecks), MavResult::kAccepted);
  EXPECT_EQ(text(), "Preflight Fail: no accelerometer and gyro data");
}

TEST_F(Commands, ARebootForgetsTheFlightAndComesBack) {
  emulator_.settle();
  ASSERT_EQ(emulator_.result(MavCmd::kPreflightRebootShutdown, {1}), MavResult::kAccepted);
  EXPECT_TRUE(emulator_.next<Heartbeat>(
      [](const auto& beat) { return beat.system_status == MavState::kBoot; }));
}

}  // namespace
}  // namespace cas::fcu
