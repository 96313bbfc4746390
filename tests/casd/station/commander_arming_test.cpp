// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include "tests/casd/station/commander_fixture.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using namespace std::chrono_literals;
using base::RunTime;
using test::FakeVehicle;
using test::kLink;
using test::VehicleCommanderTest;
using testing::HasSubstr;

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
  EXPECT_THAT(outcome.message, HasSubstr("temporarily rejected: Arming denied"));
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
  EXPECT_EQ(ask(&VehicleCommander::disarm, false).kind, OutcomeKind::kAccepted);
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
  EXPECT_TRUE(ask(&VehicleCommander::disarm, false).ok());
  vehicle_.custom_mode = 4U << 16U | 3U << 24U;  // HOLD
  run_for(3s);
  ASSERT_TRUE(armed.has_value());
  EXPECT_EQ(armed->kind, OutcomeKind::kRefused);
  EXPECT_THAT(armed->message, HasSubstr("was replaced by a newer request"));
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
  EXPECT_TRUE(ask(&VehicleCommander::disarm, false).ok());
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

struct RawCase {
  const char* name;
  VehicleCommand command;
};

VehicleCommand raw(int id, std::array<float, 7> params) {
  return {.id = static_cast<MavCmd>(id), .params = params};
}

class RawCommand : public VehicleCommanderTest, public testing::WithParamInterface<RawCase> {
 protected:
  OutcomeKind asked_of_a_vehicle_not_in_hil() {
    vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;
    meet();
    commander_.command(1, GetParam().command, false, now_, done());
    return finish().kind;
  }
};

class SpinningCommand : public RawCommand {};

TEST_P(SpinningCommand, GoesThroughTheInterlock) {
  EXPECT_EQ(asked_of_a_vehicle_not_in_hil(), OutcomeKind::kInterlock);
  EXPECT_TRUE(vehicle_.commands.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Raw, SpinningCommand,
    testing::Values(RawCase{"ArmCommand", raw(400, {1})},
                    RawCase{"ModeWithArmedFlag", raw(176, {129})},
                    RawCase{"ModeBeyondFlags", raw(176, {512})},
                    RawCase{"MotorTest", raw(209, {1})}, RawCase{"ActuatorTest", raw(310, {0.5F})},
                    RawCase{"MissionStart", raw(300, {})}, RawCase{"AuxArm", raw(218, {153, 2})},
                    RawCase{"AuxArmWithDecimals", raw(218, {153.5F, 2.5F})},
                    RawCase{"AuxMiddle", raw(218, {165, 1})},
                    RawCase{"AuxEndOfEmergencyStop", raw(218, {31, 0})},
                    RawCase{"SoloFlyClick", raw(42001, {})}, RawCase{"SoloFlyHold", raw(42002, {})},
                    RawCase{"Engine", raw(223, {1})},
                    RawCase{"CompassAgainstMotors", raw(241, {0, 0, 0, 0, 0, 1})},
                    RawCase{"EscCalibration", raw(241, {0, 0, 0, 0, 0, 0, 1})}),
    [](const auto& test) { return test.param.name; });

class StoppingCommand : public RawCommand {};

TEST_P(StoppingCommand, IsNotHeldBackAndCounts) {
  const std::uint64_t before = commander_.hands(1).disarms;
  EXPECT_EQ(asked_of_a_vehicle_not_in_hil(), OutcomeKind::kAccepted);
  EXPECT_EQ(commander_.hands(1).disarms, before + 1);
}

INSTANTIATE_TEST_SUITE_P(Raw, StoppingCommand,
                         testing::Values(RawCase{"Disarm", raw(400, {0})},
                                         RawCase{"Termination", raw(185, {1})},
                                         RawCase{"AuxDisarm", raw(218, {153, 0})},
                                         RawCase{"AuxDisarmAirMode", raw(218, {154, 0})},
                                         RawCase{"AuxArmEmergencyStop", raw(218, {165, 0})},
                                         RawCase{"AuxEmergencyStop", raw(218, {31, 2})}),
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
  commander_.set_commanding(1, false, false);
  EXPECT_EQ(finish().kind, OutcomeKind::kInterlock);
  EXPECT_EQ(vehicle_.commands.size(), 1U);
  EXPECT_EQ(arm({.not_hil = true}).kind, OutcomeKind::kInterlock);
  EXPECT_EQ(vehicle_.commands.size(), 1U);
}

/// Calls that move a vehicle, as the command port makes them.
using Move = void (*)(VehicleCommander&, RunTime, Done, bool not_hil);
struct MoveCase {
  const char* name;
  Move move;
};

class MovingCall : public ConsentingCommanderTest, public testing::WithParamInterface<MoveCase> {
 protected:
  OutcomeKind asked(bool not_hil) {
    GetParam().move(commander_, now_, done(), not_hil);
    return finish().kind;
  }
};

TEST_P(MovingCall, NeedsConsentForAnArmedVehicleThatIsNotInHil) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed;
  meet();
  EXPECT_EQ(asked(false), OutcomeKind::kInterlock);
  EXPECT_TRUE(vehicle_.commands.empty());
  EXPECT_NE(asked(true), OutcomeKind::kInterlock);
  EXPECT_FALSE(vehicle_.commands.empty());
  commander_.set_commanding(1, false, false);
  EXPECT_EQ(asked(true), OutcomeKind::kInterlock);
}

INSTANTIATE_TEST_SUITE_P(
    All, MovingCall,
    testing::Values(MoveCase{"Mode",
                             [](VehicleCommander& to, RunTime now, Done done, bool not_hil) {
                               to.set_mode(1, "MISSION", now, std::move(done), not_hil);
                             }},
                    MoveCase{"Reboot",
                             [](VehicleCommander& to, RunTime now, Done done, bool not_hil) {
                               to.reboot(1, now, std::move(done), not_hil);
                             }},
                    MoveCase{"Reposition",
                             [](VehicleCommander& to, RunTime now, Done done, bool not_hil) {
                               to.command(1, raw(192, {}), not_hil, now, std::move(done));
                             }},
                    MoveCase{"Takeoff",
                             [](VehicleCommander& to, RunTime now, Done done, bool not_hil) {
                               to.command(1, raw(22, {}), not_hil, now, std::move(done));
                             }},
                    MoveCase{"TerminationTakenBack",
                             [](VehicleCommander& to, RunTime now, Done done, bool not_hil) {
                               to.command(1, raw(185, {0}), not_hil, now, std::move(done));
                             }}),
    [](const auto& test) { return test.param.name; });

TEST_F(ConsentingCommanderTest, SendsNoArmedVehicleThatIsNotInHilToAPlaceWithoutConsent) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed;
  meet();
  say(mavlink::common::HomePosition{.latitude = 473977420, .longitude = 85455940});
  commander_.go_to(1, {.north_m = 1, .yaw_deg = {}}, now_, done());
  EXPECT_EQ(finish().kind, OutcomeKind::kInterlock);
  EXPECT_TRUE(vehicle_.int_commands.empty());
  commander_.go_to(1, {.north_m = 1, .yaw_deg = {}}, now_, done(), true);
  EXPECT_NE(finish().kind, OutcomeKind::kInterlock);
  EXPECT_FALSE(vehicle_.int_commands.empty());
}

TEST_F(VehicleCommanderTest, StopsAnArmedVehicleThatIsNotInHilWithoutConsent) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed;
  meet();
  const auto is_free = [this](auto&& call) {
    call();
    return finish().kind != OutcomeKind::kInterlock;
  };
  EXPECT_TRUE(is_free([&] { commander_.hold(1, now_, done()); }));
  EXPECT_TRUE(is_free([&] { commander_.land(1, now_, done()); }));
  EXPECT_TRUE(is_free([&] { commander_.return_home(1, now_, done()); }));
  EXPECT_TRUE(is_free([&] { commander_.set_mode(1, "LAND", now_, done()); }));
  EXPECT_TRUE(is_free([&] { commander_.disarm(1, false, now_, done()); }));
}

TEST_F(VehicleCommanderTest, RefusesATakeoffOfAVehicleThatIsNotInHil) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;
  meet();
  EXPECT_EQ(ask(&VehicleCommander::takeoff, 2.5).kind, OutcomeKind::kInterlock);
  EXPECT_TRUE(vehicle_.commands.empty());
}

TEST_F(VehicleCommanderTest, RepeatsAModeWithTheFlagsOfTheNewestHeartbeat) {
  const auto armed_flag = [this] {
    return (static_cast<unsigned>(vehicle_.commands.back().param1) & 128U) != 0;
  };
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed;
  vehicle_.script.answers = 0;
  meet();
  commander_.hold(1, now_, done());
  run_for(100ms);
  ASSERT_EQ(vehicle_.commands.size(), 1U);
  EXPECT_TRUE(armed_flag());
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;  // a person disarms it
  vehicle_.say_heartbeat(now_);
  run_for(1s);
  ASSERT_GE(vehicle_.commands.size(), 2U);
  EXPECT_FALSE(armed_flag());
  finish();
}

}  // namespace
}  // namespace cas::casd
