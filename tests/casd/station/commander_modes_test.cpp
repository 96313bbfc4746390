// SPDX-License-Identifier: BSD-3-Clause
#include "tests/casd/station/commander_fixture.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using namespace std::chrono_literals;
using test::VehicleCommanderTest;

constexpr std::uint32_t kHold = 4U << 16U | 3U << 24U;

TEST_F(VehicleCommanderTest, SetsPx4ModesByMainAndSubMode) {
  meet();
  EXPECT_TRUE(ask(&VehicleCommander::hold).ok());
  EXPECT_EQ(vehicle_.commands.at(0).param1, 33.0F);  // custom and HIL
  EXPECT_EQ(vehicle_.commands.at(0).param2, 4.0F);
  EXPECT_EQ(vehicle_.commands.at(0).param3, 3.0F);
}

TEST_F(VehicleCommanderTest, HasAModeOnlyOnceTheHeartbeatShowsIt) {
  meet();
  vehicle_.script.keeps_mode = true;
  commander_.set_mode(1, "HOLD", now_, done());
  run_for(1500ms);
  EXPECT_FALSE(outcome_.has_value())
      << "an acknowledgement and a HEARTBEAT with the mode of before";
  vehicle_.custom_mode = kHold;
  EXPECT_TRUE(finish().ok());
}

// PX4 v1.16.1: POSCTL without sticks is acknowledged twice, and the vehicle stays in HOLD.
TEST_F(VehicleCommanderTest, RefusesAModeThatIsAcceptedAndThenRejected) {
  vehicle_.custom_mode = kHold;
  meet();
  vehicle_.script.keeps_mode = true;
  vehicle_.script.then = MavResult::kTemporarilyRejected;
  vehicle_.script.text = "Switching to POSCTL is not possible";
  const Outcome outcome = ask(&VehicleCommander::set_mode, "POSCTL");
  EXPECT_EQ(outcome.kind, OutcomeKind::kRefused);
  EXPECT_EQ(outcome.result, MavResult::kTemporarilyRejected);
  EXPECT_EQ(outcome.message,
            "MAV_CMD 176 (set mode) was accepted, then temporarily rejected: it is in HOLD; it "
            "says: Switching to POSCTL is not possible");
}

TEST_F(VehicleCommanderTest, BelievesTheHeartbeatAgainstASecondAcknowledgement) {
  meet();
  vehicle_.script.then = MavResult::kTemporarilyRejected;
  EXPECT_TRUE(ask(&VehicleCommander::set_mode, "HOLD").ok());
}

// The simulator is paused in lockstep: casd's time does not advance.
TEST_F(VehicleCommanderTest, WaitsForAModeNoLongerThanItsPatienceByTheWallClock) {
  meet();
  vehicle_.script.keeps_mode = true;
  commander_.set_mode(1, "HOLD", now_, done());
  run_for(50ms);
  const base::RunTime wall{1h};
  commander_.wall_tick(wall);
  commander_.wall_tick(wall + 9s);
  EXPECT_FALSE(outcome_.has_value());
  commander_.wall_tick(wall + 10s);
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_EQ(outcome_->kind, OutcomeKind::kTimeout);
  EXPECT_EQ(
      outcome_->message,
      "MAV_CMD 176 (set mode) was accepted, and no HEARTBEAT came within 10.0 s of real time; "
      "the vehicle's time stood still");
}

// A simulation at a hundredth of real time: its 3 s are 300 s of ours.
TEST_F(VehicleCommanderTest, DoesNotGiveUpByTheWallClockWhileTimeGoesOn) {
  meet();
  vehicle_.script.keeps_mode = true;
  commander_.set_mode(1, "HOLD", now_, done());
  run_for(50ms);
  const base::RunTime wall{1h};
  commander_.wall_tick(wall);
  run_for(50ms);
  commander_.wall_tick(wall + 11s);
  EXPECT_FALSE(outcome_.has_value());
  commander_.wall_tick(wall + 21s);
  EXPECT_TRUE(outcome_.has_value());
}

TEST_F(VehicleCommanderTest, DoesNotGiveUpByTheWallClockWhatIsNotAccepted) {
  meet();
  vehicle_.script.answers = 0;
  commander_.set_mode(1, "HOLD", now_, done());
  commander_.wall_tick(base::RunTime{1h});
  commander_.wall_tick(base::RunTime{2h});
  EXPECT_FALSE(outcome_.has_value());
}

TEST_F(VehicleCommanderTest, RefusesAModeThatIsAcceptedAndDoesNotCome) {
  vehicle_.custom_mode = kHold;
  meet();
  vehicle_.script.keeps_mode = true;
  const Outcome outcome = ask(&VehicleCommander::set_mode, "POSCTL");
  EXPECT_EQ(outcome.kind, OutcomeKind::kRefused);
  EXPECT_EQ(outcome.message,
            "MAV_CMD 176 (set mode) was accepted and not carried out within 3.0 s: it is in HOLD");
}

TEST_F(VehicleCommanderTest, AsksForTheHeartbeatThatShowsTheMode) {
  meet();
  beating_ = false;  // as in lockstep, while time is stopped
  vehicle_.script.beats_on_request = true;
  commander_.set_mode(1, "HOLD", now_, done());
  const base::RunTime asked = now_;
  EXPECT_TRUE(finish().ok());
  EXPECT_LT(now_ - asked, 100ms);
}

TEST_F(VehicleCommanderTest, TakesNoHeartbeatOfBeforeForTheModeThatWasAskedFor) {
  vehicle_.custom_mode = kHold;
  meet();
  beating_ = false;
  const Outcome outcome = ask(&VehicleCommander::set_mode, "HOLD");
  EXPECT_EQ(outcome.kind, OutcomeKind::kTimeout);
  EXPECT_NE(outcome.message.find("no HEARTBEAT came within 3.0 s"), std::string::npos)
      << outcome.message;
}

TEST_F(VehicleCommanderTest, HearsTheHeartbeatThatComesBetweenTheDeadlineAndTheTick) {
  meet();
  beating_ = false;
  commander_.set_mode(1, "HOLD", now_, done());  // acknowledged 5 ms later, ticks come each 50 ms
  run_for(20ms);
  vehicle_.say_heartbeat(now_ + 3s);
  const Outcome outcome = finish();
  EXPECT_TRUE(outcome.ok()) << outcome.message;
}

TEST_F(VehicleCommanderTest, RefusesNoModeOnAHeartbeatOfBefore) {
  vehicle_.script.keeps_mode = true;
  meet();
  beating_ = false;
  const Outcome outcome = ask(&VehicleCommander::set_mode, "HOLD");
  EXPECT_EQ(outcome.kind, OutcomeKind::kTimeout) << outcome.message;
}

TEST_F(VehicleCommanderTest, AnswersAnUnknownModeWithTheModesThereAre) {
  meet();
  const Outcome outcome = ask(&VehicleCommander::set_mode, "WARP");
  EXPECT_EQ(outcome.kind, OutcomeKind::kInvalid);
  EXPECT_NE(outcome.message.find("POSCTL"), std::string::npos);
}

}  // namespace
}  // namespace cas::casd
