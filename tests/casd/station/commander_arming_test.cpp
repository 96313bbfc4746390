// SPDX-License-Identifier: BSD-3-Clause
#include "tests/casd/station/commander_fixture.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using namespace std::chrono_literals;
using base::RunTime;
using test::FakeVehicle;
using test::kLink;
using test::VehicleCommanderTest;

TEST_F(VehicleCommanderTest, ArmsWhenTheVehicleAccepts) {
  meet();
  EXPECT_EQ(arm().kind, OutcomeKind::kAccepted);
  ASSERT_EQ(vehicle_.commands.size(), 1U);
  EXPECT_EQ(vehicle_.commands[0].command, MavCmd::kComponentArmDisarm);
  EXPECT_EQ(vehicle_.commands[0].param1, 1.0F);
  EXPECT_EQ(vehicle_.commands[0].param2, 0.0F);
  EXPECT_EQ(vehicle_.commands[0].target_component, 1);
}

TEST_F(VehicleCommanderTest, ForcesWithTheMagicNumber) {
  meet();
  arm({.force = true});
  EXPECT_EQ(vehicle_.commands.at(0).param2, 21196.0F);
}

TEST_F(VehicleCommanderTest, ReportsARefusalWithItsStatusText) {
  meet();
  vehicle_.script.result = MavResult::kTemporarilyRejected;
  vehicle_.script.text = "Arming denied: no global position";
  const Outcome outcome = arm();
  EXPECT_EQ(outcome.kind, OutcomeKind::kRefused);
  EXPECT_EQ(outcome.result, MavResult::kTemporarilyRejected);
  EXPECT_EQ(outcome.status_texts, std::vector<std::string>{vehicle_.script.text});
  EXPECT_NE(outcome.message.find("temporarily rejected: Arming denied"), std::string::npos)
      << outcome.message;
}

TEST(VehicleCommanderInLockstep, AnswersARefusalWhileTimeStands) {
  FakeVehicle vehicle;
  mav::PacketParser parser(mavlink::common::table());
  constexpr RunTime kNow{1s};
  VehicleCommander commander(
      {.ask_on_sight = false, .command_timing = {.text_grace = {}}},
      [&](std::span<const std::uint8_t> bytes, std::span<const Path>) {
        parser.feed(bytes, [&](const mav::PacketView& packet) { vehicle.handle(packet, kNow); });
      });
  const auto hear = [&] {
    while (const auto packet = vehicle.take(kNow)) {
      commander.on_packet(kLink, mav::view_packet(packet->view()), kNow);
    }
  };
  vehicle.say_heartbeat(kNow);
  hear();
  vehicle.script.delay = {};
  vehicle.script.result = MavResult::kTemporarilyRejected;
  std::optional<Outcome> outcome;
  commander.arm(1, {}, kNow, [&](const Outcome& o) { outcome = o; });
  hear();
  ASSERT_TRUE(outcome.has_value()) << "without a tick";
  EXPECT_EQ(outcome->kind, OutcomeKind::kRefused);
}

TEST_F(VehicleCommanderTest, RepeatsWithARisingConfirmationUntilHeard) {
  meet();
  vehicle_.script.deaf_for = 2;
  EXPECT_EQ(arm().kind, OutcomeKind::kAccepted);
  ASSERT_EQ(vehicle_.commands.size(), 3U);
  EXPECT_EQ(vehicle_.commands[0].confirmation, 0);
  EXPECT_EQ(vehicle_.commands[1].confirmation, 1);
  EXPECT_EQ(vehicle_.commands[2].confirmation, 2);
}

TEST_F(VehicleCommanderTest, GivesUpAfterFiveTries) {
  meet();
  vehicle_.script.answers = 0;
  const RunTime start = now_;
  EXPECT_EQ(arm().kind, OutcomeKind::kTimeout);
  EXPECT_EQ(vehicle_.commands.size(), 5U);
  EXPECT_LT(now_ - start, 5s);
}

TEST_F(VehicleCommanderTest, TakesALateAnswer) {
  meet();
  vehicle_.script.delay = 1200ms;
  EXPECT_EQ(arm().kind, OutcomeKind::kAccepted);
  EXPECT_EQ(vehicle_.commands.size(), 2U);
}

TEST_F(VehicleCommanderTest, HearsTwoAnswersAsOne) {
  meet();
  vehicle_.script.answers = 2;
  EXPECT_EQ(arm().kind, OutcomeKind::kAccepted);
  run_for(2s);  // the second answer would end the request again
}

TEST_F(VehicleCommanderTest, WaitsThroughInProgress) {
  meet();
  vehicle_.script.in_progress_first = true;
  vehicle_.script.delay = 8s;
  EXPECT_EQ(arm().kind, OutcomeKind::kAccepted);
  EXPECT_EQ(vehicle_.commands.size(), 1U);
}

TEST_F(VehicleCommanderTest, DisarmReplacesAnArmThatIsUnderWay) {
  meet();
  vehicle_.script.answers = 0;
  std::optional<Outcome> armed;
  commander_.arm(1, {}, now_, [&](const Outcome& outcome) { armed = outcome; });
  run_for(100ms);
  vehicle_.script.answers = 1;
  commander_.disarm(1, false, now_, done());
  EXPECT_EQ(finish().kind, OutcomeKind::kAccepted);
  ASSERT_TRUE(armed.has_value());
  EXPECT_EQ(armed->kind, OutcomeKind::kRefused);
  EXPECT_EQ(vehicle_.commands.back().param1, 0.0F);
}

// The HEARTBEAT that shows HOLD comes up to 3 s after its acknowledgement.
TEST_F(VehicleCommanderTest, ADisarmIsNotOvertakenByAnArmThatWaitsForHold) {
  vehicle_.custom_mode = 1U << 16U;  // MANUAL
  meet();
  vehicle_.script.result = MavResult::kDenied;
  std::optional<Outcome> armed;
  commander_.arm(1, {}, now_, [&](const Outcome& outcome) { armed = outcome; });
  run_for(100ms);
  vehicle_.script.result = MavResult::kAccepted;
  vehicle_.script.keeps_mode = true;
  for (int i = 0; i < 100 && vehicle_.commands.back().command == MavCmd::kComponentArmDisarm; ++i) {
    run_for(10ms);
  }
  run_for(50ms);
  ASSERT_FALSE(armed.has_value());
  commander_.disarm(1, false, now_, done());
  EXPECT_TRUE(finish().ok());
  vehicle_.custom_mode = 4U << 16U | 3U << 24U;  // HOLD
  run_for(3s);
  ASSERT_TRUE(armed.has_value());
  EXPECT_EQ(armed->kind, OutcomeKind::kRefused);
  EXPECT_NE(armed->message.find("was replaced by a newer request"), std::string::npos)
      << armed->message;
  for (std::size_t i = 1; i < vehicle_.commands.size(); ++i) {
    const bool arms = vehicle_.commands[i].command == MavCmd::kComponentArmDisarm &&
                      vehicle_.commands[i].param1 == 1.0F;
    EXPECT_FALSE(arms) << "command " << i;
  }
}

TEST_F(VehicleCommanderTest, AnArmInAStickModeThatADisarmReplacesIsNotTriedAgain) {
  vehicle_.custom_mode = 1U << 16U;  // MANUAL
  meet();
  vehicle_.script.answers = 0;
  commander_.arm(1, {}, now_, [](const Outcome&) {});
  run_for(100ms);
  vehicle_.script.answers = 1;
  commander_.disarm(1, false, now_, done());
  EXPECT_TRUE(finish().ok());
  run_for(3s);
  EXPECT_EQ(vehicle_.commands.size(), 2U);
  EXPECT_EQ(vehicle_.commands.back().param1, 0.0F);
}

TEST_F(VehicleCommanderTest, RefusesToArmWithoutTheHilFlag) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;
  meet();
  EXPECT_EQ(arm().kind, OutcomeKind::kInterlock);
  EXPECT_EQ(arm({.force = true}).kind, OutcomeKind::kInterlock);
  EXPECT_EQ(arm({.not_hil = true}).kind, OutcomeKind::kInterlock);  // no consent
  EXPECT_TRUE(vehicle_.commands.empty());
}

TEST_F(VehicleCommanderTest, RefusesToArmOnAnOldHeartbeat) {
  meet();
  beating_ = false;
  run_for(5s);
  EXPECT_EQ(arm().kind, OutcomeKind::kInterlock);
  EXPECT_TRUE(vehicle_.commands.empty());
}

struct SpinningCase {
  const char* name;
  MavCmd id;
  float param1;
};

class SpinningCommand : public VehicleCommanderTest,
                        public testing::WithParamInterface<SpinningCase> {};

TEST_P(SpinningCommand, GoesThroughTheInterlock) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;
  meet();
  VehicleCommand command;
  command.id = GetParam().id;
  command.params[0] = GetParam().param1;
  commander_.command(1, command, false, now_, done());
  EXPECT_EQ(finish().kind, OutcomeKind::kInterlock);
  EXPECT_TRUE(vehicle_.commands.empty());
}

INSTANTIATE_TEST_SUITE_P(Raw, SpinningCommand,
                         testing::Values(SpinningCase{"ArmCommand", MavCmd::kComponentArmDisarm, 1},
                                         SpinningCase{"ModeWithArmedFlag", MavCmd::kDoSetMode, 129},
                                         SpinningCase{"ModeBeyondFlags", MavCmd::kDoSetMode, 512},
                                         SpinningCase{"MotorTest", MavCmd::kDoMotorTest, 1},
                                         SpinningCase{"ActuatorTest", MavCmd::kActuatorTest, 0.5F},
                                         SpinningCase{"MissionStart", MavCmd::kMissionStart, 0}),
                         [](const auto& test) { return test.param.name; });

class ConsentingCommanderTest : public VehicleCommanderTest {
 protected:
  ConsentingCommanderTest()
      : VehicleCommanderTest({.allow_not_hil = true, .ask_on_sight = false}) {}
};

TEST_F(ConsentingCommanderTest, ArmsWithoutHilOnlyWhenAskedTo) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;
  meet();
  EXPECT_EQ(arm().kind, OutcomeKind::kInterlock);
  EXPECT_EQ(arm({.not_hil = true}).kind, OutcomeKind::kAccepted);
}

TEST_F(ConsentingCommanderTest, SendsNothingMoreOnceTheConsentIsWithdrawn) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;
  vehicle_.script.answers = 0;
  meet();
  commander_.arm(1, {.not_hil = true}, now_, done());
  run_for(100ms);
  ASSERT_EQ(vehicle_.commands.size(), 1U);
  commander_.set_commanding(1, false);
  EXPECT_EQ(finish().kind, OutcomeKind::kInterlock);
  EXPECT_EQ(vehicle_.commands.size(), 1U);
  EXPECT_EQ(arm({.not_hil = true}).kind, OutcomeKind::kInterlock);
  EXPECT_EQ(vehicle_.commands.size(), 1U);
}

TEST_F(ConsentingCommanderTest, ChangesTheModeOfAnArmedVehicleWithoutConsent) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed;
  meet();
  commander_.set_commanding(1, false);
  commander_.set_mode(1, "HOLD", now_, done());
  EXPECT_EQ(finish().kind, OutcomeKind::kAccepted);
}

}  // namespace
}  // namespace cas::casd
