// SPDX-License-Identifier: BSD-3-Clause
#include "casd/vehicle_commander.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/casd/fake_vehicle.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using namespace std::chrono_literals;
using base::Duration;
using base::RunTime;
using test::FakeVehicle;

constexpr LinkId kLink = 2;

/// A commander and one vehicle on a virtual clock.
class VehicleCommanderTest : public testing::Test {
 protected:
  explicit VehicleCommanderTest(CommanderOptions options = {.ask_on_sight = false})
      : commander_(options, [this](std::span<const std::uint8_t> bytes) {
          parser_.feed(bytes,
                       [this](const mav::PacketView& packet) { vehicle_.handle(packet, now_); });
        }) {}

  /// Lets the vehicle be heard.
  void meet() {
    vehicle_.say_heartbeat(now_);
    run_for(50ms);
  }

  void run_for(Duration time) {
    for (const RunTime end = now_ + time; now_ < end; now_ += 5ms) step();
  }
  /// Runs until the request has ended. @return its outcome
  Outcome finish() {
    for (const RunTime end = now_ + 60s; !outcome_ && now_ < end; now_ += 5ms) step();
    EXPECT_TRUE(outcome_.has_value()) << "the request never ended";
    return outcome_.value_or(Outcome{});
  }
  Done done() {
    outcome_.reset();
    return [this](const Outcome& outcome) {
      EXPECT_FALSE(outcome_.has_value()) << "a request ended twice";
      outcome_ = outcome;
    };
  }
  Outcome arm(VehicleCommander::ArmOptions options = {}) {
    commander_.arm(1, options, now_, done());
    return finish();
  }

  RunTime now_{1s};
  FakeVehicle vehicle_;
  mav::PacketParser parser_{mavlink::common::table()};
  VehicleCommander commander_;
  std::optional<Outcome> outcome_;

 private:
  void step() {
    while (const auto packet = vehicle_.take(now_)) {
      mav::PacketParser parser(mavlink::common::table());
      parser.feed(packet->view(),
                  [this](const mav::PacketView& view) { commander_.on_packet(kLink, view, now_); });
    }
    if (now_ - last_beat_ >= 1s) {
      if (last_beat_ != RunTime{} && beating_) vehicle_.say_heartbeat(now_);
      last_beat_ = now_;
    }
    if (now_.time_since_epoch() % 50ms == 0ms) commander_.tick(now_);
  }
  RunTime last_beat_{};

 protected:
  bool beating_ = true;
};

TEST_F(VehicleCommanderTest, KnowsAVehicleByItsHeartbeat) {
  EXPECT_TRUE(commander_.vehicles().empty());
  meet();
  ASSERT_NE(commander_.find(1), nullptr);
  EXPECT_EQ(commander_.find(1)->autopilot(), Autopilot::kPx4);
  EXPECT_TRUE(commander_.find(1)->hil());
  EXPECT_FALSE(commander_.find(1)->armed());
  EXPECT_EQ(commander_.find(1)->link(), kLink);
}

TEST_F(VehicleCommanderTest, TakesASimulatorForNoVehicle) {
  vehicle_.autopilot = MavAutopilot::kInvalid;
  meet();
  EXPECT_TRUE(commander_.vehicles().empty());
}

TEST_F(VehicleCommanderTest, SendsOneHeartbeatASecond) {
  commander_.tick(now_);
  run_for(10s);
  EXPECT_NEAR(vehicle_.heartbeats, 10, 1);
}

TEST_F(VehicleCommanderTest, ArmsWhenTheVehicleAccepts) {
  meet();
  EXPECT_EQ(arm().verdict, Verdict::kAccepted);
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
  EXPECT_EQ(outcome.verdict, Verdict::kRefused);
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
      [&](std::span<const std::uint8_t> bytes) {
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
  EXPECT_EQ(outcome->verdict, Verdict::kRefused);
}

TEST_F(VehicleCommanderTest, RepeatsWithARisingConfirmationUntilHeard) {
  meet();
  vehicle_.script.deaf_for = 2;
  EXPECT_EQ(arm().verdict, Verdict::kAccepted);
  ASSERT_EQ(vehicle_.commands.size(), 3U);
  EXPECT_EQ(vehicle_.commands[0].confirmation, 0);
  EXPECT_EQ(vehicle_.commands[1].confirmation, 1);
  EXPECT_EQ(vehicle_.commands[2].confirmation, 2);
}

TEST_F(VehicleCommanderTest, GivesUpAfterFiveTries) {
  meet();
  vehicle_.script.answers = 0;
  const RunTime start = now_;
  EXPECT_EQ(arm().verdict, Verdict::kTimeout);
  EXPECT_EQ(vehicle_.commands.size(), 5U);
  EXPECT_LT(now_ - start, 5s);
}

TEST_F(VehicleCommanderTest, TakesALateAnswer) {
  meet();
  vehicle_.script.delay = 1200ms;
  EXPECT_EQ(arm().verdict, Verdict::kAccepted);
  EXPECT_EQ(vehicle_.commands.size(), 2U);
}

TEST_F(VehicleCommanderTest, HearsTwoAnswersAsOne) {
  meet();
  vehicle_.script.answers = 2;
  EXPECT_EQ(arm().verdict, Verdict::kAccepted);
  run_for(2s);  // the second answer would end the request again
}

TEST_F(VehicleCommanderTest, WaitsThroughInProgress) {
  meet();
  vehicle_.script.in_progress_first = true;
  vehicle_.script.delay = 8s;
  EXPECT_EQ(arm().verdict, Verdict::kAccepted);
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
  EXPECT_EQ(finish().verdict, Verdict::kAccepted);
  ASSERT_TRUE(armed.has_value());
  EXPECT_EQ(armed->verdict, Verdict::kRefused);
  EXPECT_EQ(vehicle_.commands.back().param1, 0.0F);
}

TEST_F(VehicleCommanderTest, RefusesToArmWithoutTheHilFlag) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;
  meet();
  EXPECT_EQ(arm().verdict, Verdict::kInterlock);
  EXPECT_EQ(arm({.force = true}).verdict, Verdict::kInterlock);
  EXPECT_EQ(arm({.not_hil = true}).verdict, Verdict::kInterlock);  // no consent
  EXPECT_TRUE(vehicle_.commands.empty());
}

TEST_F(VehicleCommanderTest, RefusesToArmOnAnOldHeartbeat) {
  meet();
  beating_ = false;
  run_for(5s);
  EXPECT_EQ(arm().verdict, Verdict::kInterlock);
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
  EXPECT_EQ(finish().verdict, Verdict::kInterlock);
  EXPECT_TRUE(vehicle_.commands.empty());
}

INSTANTIATE_TEST_SUITE_P(Raw, SpinningCommand,
                         testing::Values(SpinningCase{"ArmCommand", MavCmd::kComponentArmDisarm, 1},
                                         SpinningCase{"ModeWithArmedFlag", MavCmd::kDoSetMode, 129},
                                         SpinningCase{"ModeBeyondFlags", MavCmd::kDoSetMode, 512},
                                         SpinningCase{"MotorTest", MavCmd::kDoMotorTest, 1},
                                         SpinningCase{"ActuatorTest", MavCmd::kActuatorTest, 0.5F}),
                         [](const auto& test) { return test.param.name; });

class ConsentingCommanderTest : public VehicleCommanderTest {
 protected:
  ConsentingCommanderTest()
      : VehicleCommanderTest({.allow_not_hil = true, .ask_on_sight = false}) {}
};

TEST_F(ConsentingCommanderTest, ArmsWithoutHilOnlyWhenAskedTo) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;
  meet();
  EXPECT_EQ(arm().verdict, Verdict::kInterlock);
  EXPECT_EQ(arm({.not_hil = true}).verdict, Verdict::kAccepted);
}

TEST_F(VehicleCommanderTest, Px4TakesOffToAnAltitudeAboveSeaLevel) {
  meet();
  HomePosition home;
  home.altitude = 488'000;
  vehicle_.say(home, now_);
  run_for(50ms);
  commander_.takeoff(1, 2.5, now_, done());
  EXPECT_TRUE(finish().ok());
  ASSERT_EQ(vehicle_.commands.size(), 1U);
  EXPECT_EQ(vehicle_.commands[0].command, MavCmd::kNavTakeoff);
  EXPECT_FLOAT_EQ(vehicle_.commands[0].param7, 490.5F);
  EXPECT_TRUE(std::isnan(vehicle_.commands[0].param5));
}

TEST_F(VehicleCommanderTest, Px4TakesOffByParameterWhileHomeIsUnknown) {
  vehicle_.params["MIS_TAKEOFF_ALT"] = {.value = 10};
  meet();
  commander_.takeoff(1, 2.5, now_, done());
  EXPECT_TRUE(finish().ok());
  EXPECT_FLOAT_EQ(static_cast<float>(vehicle_.params["MIS_TAKEOFF_ALT"].value), 2.5F);
  ASSERT_EQ(vehicle_.commands.size(), 1U);
  EXPECT_TRUE(std::isnan(vehicle_.commands[0].param7));
}

TEST_F(VehicleCommanderTest, ArduPilotTakesOffInGuidedToAHeightAboveHome) {
  vehicle_.autopilot = MavAutopilot::kArdupilotmega;
  meet();
  commander_.takeoff(1, 2.5, now_, done());
  EXPECT_TRUE(finish().ok());
  ASSERT_EQ(vehicle_.commands.size(), 2U);
  EXPECT_EQ(vehicle_.commands[0].command, MavCmd::kDoSetMode);
  EXPECT_EQ(vehicle_.commands[0].param2, 4.0F);  // GUIDED
  EXPECT_EQ(vehicle_.commands[1].command, MavCmd::kNavTakeoff);
  EXPECT_EQ(vehicle_.commands[1].param7, 2.5F);
}

TEST_F(VehicleCommanderTest, GoesToALocalPlaceByLatitudeAndLongitude) {
  meet();
  HomePosition home;
  home.latitude = 473977420;
  home.longitude = 85455940;
  home.altitude = 488'000;
  home.z = -0.5F;  // home lies 0.5 m above the origin of the local frame
  vehicle_.say(home, now_);
  run_for(50ms);
  commander_.go_to(1, {.north_m = 111.19, .east_m = 0, .down_m = -3, .yaw_deg = 90}, now_, done());
  EXPECT_TRUE(finish().ok());
  ASSERT_EQ(vehicle_.int_commands.size(), 1U);
  const CommandInt& command = vehicle_.int_commands[0];
  EXPECT_EQ(command.command, MavCmd::kDoReposition);
  EXPECT_NEAR(command.x, 473977420 + 10000, 20);  // 111.19 m are a thousandth of a degree
  EXPECT_NEAR(command.y, 85455940, 1);
  EXPECT_FLOAT_EQ(command.z, 490.5F);
  EXPECT_FLOAT_EQ(command.param4, 1.5707964F);
  EXPECT_EQ(command.param2, 1.0F);
}

TEST_F(VehicleCommanderTest, RefusesPlacesNoVehicleReaches) {
  meet();
  HomePosition home;
  home.latitude = 473977420;
  home.longitude = 85455940;
  vehicle_.say(home, now_);
  run_for(50ms);
  commander_.go_to(1, {.north_m = 1e300, .yaw_deg = {}}, now_, done());
  EXPECT_EQ(finish().verdict, Verdict::kInvalid);
  commander_.takeoff(1, 1e300, now_, done());
  EXPECT_EQ(finish().verdict, Verdict::kInvalid);
  EXPECT_TRUE(vehicle_.commands.empty());
  EXPECT_TRUE(vehicle_.int_commands.empty());
}

TEST_F(VehicleCommanderTest, SaysWhyItCannotGoWithoutHome) {
  meet();
  commander_.go_to(1, {}, now_, done());
  EXPECT_EQ(finish().verdict, Verdict::kRefused);
}

TEST_F(VehicleCommanderTest, SetsPx4ModesByMainAndSubMode) {
  meet();
  commander_.hold(1, now_, done());
  EXPECT_TRUE(finish().ok());
  EXPECT_EQ(vehicle_.commands.at(0).param1, 33.0F);  // custom and HIL
  EXPECT_EQ(vehicle_.commands.at(0).param2, 4.0F);
  EXPECT_EQ(vehicle_.commands.at(0).param3, 3.0F);
}

TEST_F(VehicleCommanderTest, AnswersAnUnknownModeWithTheModesThereAre) {
  meet();
  commander_.set_mode(1, "WARP", now_, done());
  const Outcome outcome = finish();
  EXPECT_EQ(outcome.verdict, Verdict::kInvalid);
  EXPECT_NE(outcome.message.find("POSCTL"), std::string::npos);
}

TEST_F(VehicleCommanderTest, ResolvesTheOnlyVehicle) {
  EXPECT_EQ(std::get<Outcome>(commander_.resolve({})).verdict, Verdict::kNoSuchVehicle);
  meet();
  EXPECT_EQ(std::get<std::uint8_t>(commander_.resolve({})), 1);
  EXPECT_EQ(std::get<Outcome>(commander_.resolve(7)).verdict, Verdict::kNoSuchVehicle);
}

TEST_F(VehicleCommanderTest, AsksForTheVehicleWhenThereAreTwo) {
  meet();
  FakeVehicle second({2, 1});
  second.say_heartbeat(now_);
  parser_.feed(second.take(now_)->view(), [this](const mav::PacketView& packet) {
    commander_.on_packet(kLink, packet, now_);
  });
  EXPECT_EQ(std::get<Outcome>(commander_.resolve({})).verdict, Verdict::kInvalid);
  EXPECT_EQ(std::get<std::uint8_t>(commander_.resolve(2)), 2);
}

TEST_F(VehicleCommanderTest, RemembersTheNewestTenStatusTexts) {
  meet();
  for (int i = 0; i < 15; ++i) vehicle_.say_text("text " + std::to_string(i), now_);
  run_for(50ms);
  const auto& texts = commander_.find(1)->status_texts();
  ASSERT_EQ(texts.size(), 10U);
  EXPECT_EQ(texts.back().text, "text 14");
}

TEST_F(VehicleCommanderTest, JoinsAStatusTextInChunks) {
  meet();
  Statustext chunk;
  chunk.id = 7;
  mav::set_text(chunk.text, std::string(50, 'a'));
  vehicle_.say(chunk, now_);
  chunk.chunk_seq = 1;
  mav::set_text(chunk.text, "b");
  vehicle_.say(chunk, now_);
  run_for(50ms);
  ASSERT_EQ(commander_.find(1)->status_texts().size(), 1U);
  EXPECT_EQ(commander_.find(1)->status_texts()[0].text, std::string(50, 'a') + "b");
}

TEST_F(VehicleCommanderTest, NeverHoldsMoreVehiclesThanItsBound) {
  for (std::uint8_t system = 1; system < 200; ++system) {
    FakeVehicle one({system, 1});
    one.say_heartbeat(now_);
    parser_.feed(one.take(now_)->view(), [this](const mav::PacketView& packet) {
      commander_.on_packet(kLink, packet, now_);
    });
  }
  EXPECT_EQ(commander_.vehicles().size(), 32U);
}

// Parameters.

TEST_F(VehicleCommanderTest, SetsAParameterAfterAskingForItsType) {
  vehicle_.params["MC_ROLL_P"] = {.value = 6.5};
  meet();
  commander_.set_param(1, "MC_ROLL_P", 7.2, now_, done());
  const Outcome outcome = finish();
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(vehicle_.param_reads, 1);
  EXPECT_FLOAT_EQ(static_cast<float>(outcome.parameters.at("MC_ROLL_P")), 7.2F);
  commander_.set_param(1, "MC_ROLL_P", 7.3, now_, done());
  EXPECT_TRUE(finish().ok());
  EXPECT_EQ(vehicle_.param_reads, 1);  // the type is known now
}

TEST_F(VehicleCommanderTest, SendsPx4IntegersAsBytes) {
  vehicle_.params["SYS_HITL"] = {.value = 0, .type = MavParamType::kInt32};
  meet();
  commander_.set_param(1, "SYS_HITL", 1, now_, done());
  EXPECT_TRUE(finish().ok());
  EXPECT_EQ(std::bit_cast<std::uint32_t>(vehicle_.param_sets.at(0).param_value), 1U);
  EXPECT_EQ(vehicle_.params["SYS_HITL"].value, 1);
}

TEST_F(VehicleCommanderTest, SendsArduPilotIntegersAsNumbers) {
  vehicle_.autopilot = MavAutopilot::kArdupilotmega;
  vehicle_.params["FRAME_TYPE"] = {.value = 0, .type = MavParamType::kInt8};
  meet();
  commander_.set_param(1, "FRAME_TYPE", -3, now_, done());
  EXPECT_TRUE(finish().ok());
  EXPECT_EQ(vehicle_.param_sets.at(0).param_value, -3.0F);
  EXPECT_EQ(vehicle_.params["FRAME_TYPE"].value, -3);
}

TEST_F(VehicleCommanderTest, SaysWhichValueTheVehicleKeeps) {
  vehicle_.params["MC_ROLL_P"] = {.value = 6.5, .high = 12};
  meet();
  commander_.set_param(1, "MC_ROLL_P", 99, now_, done());
  const Outcome outcome = finish();
  EXPECT_EQ(outcome.verdict, Verdict::kRefused);
  EXPECT_EQ(outcome.parameters.at("MC_ROLL_P"), 12);
  EXPECT_NE(outcome.message.find("keeps MC_ROLL_P = 12 (asked: 99)"), std::string::npos)
      << outcome.message;
}

TEST_F(VehicleCommanderTest, RefusesAFractionInAnIntegerParameter) {
  vehicle_.params["SYS_HITL"] = {.value = 0, .type = MavParamType::kInt32};
  meet();
  commander_.set_param(1, "SYS_HITL", 0.5, now_, done());
  EXPECT_EQ(finish().verdict, Verdict::kInvalid);
  EXPECT_TRUE(vehicle_.param_sets.empty());
}

TEST_F(VehicleCommanderTest, RepeatsALostParamSet) {
  vehicle_.params["MC_ROLL_P"] = {.value = 6.5};
  meet();
  vehicle_.script.deaf_for = 3;
  commander_.set_param(1, "MC_ROLL_P", 7, now_, done());
  EXPECT_TRUE(finish().ok());
  EXPECT_EQ(vehicle_.params["MC_ROLL_P"].value, 7);
}

TEST_F(VehicleCommanderTest, GivesUpOnAParameterThatTheVehicleDoesNotHave) {
  meet();
  commander_.read_param(1, "NOPE", now_, done());
  EXPECT_EQ(finish().verdict, Verdict::kTimeout);
  EXPECT_EQ(vehicle_.param_reads, 5);
}

TEST_F(VehicleCommanderTest, ListsAllParametersAndFetchesTheLostOnes) {
  for (int i = 0; i < 40; ++i) {
    vehicle_.params["P" + std::to_string(100 + i)] = {.value = i * 1.0};
  }
  vehicle_.lost_in_list = {"P103", "P139", "P117"};
  meet();
  commander_.list_params(1, now_, done());
  const Outcome outcome = finish();
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.parameters.size(), 40U);
  EXPECT_EQ(outcome.parameters.at("P139"), 39);
  EXPECT_EQ(vehicle_.param_reads, 3);
}

TEST_F(VehicleCommanderTest, EndsAListThatNeverComes) {
  meet();
  commander_.list_params(1, now_, done());
  EXPECT_EQ(finish().verdict, Verdict::kTimeout);
}

TEST_F(VehicleCommanderTest, SetsTheGivenGainsAndAnswersWithAll) {
  vehicle_.params["MC_ROLLRATE_P"] = {.value = 0.15};
  vehicle_.params["MC_ROLLRATE_I"] = {.value = 0.2};
  vehicle_.params["MC_ROLLRATE_D"] = {.value = 0.003};
  meet();
  const GainMap map = GainMap::load(CAS_SOURCE_DIR "/config/gains.yaml");
  const GainLoop* loop = map.find(Autopilot::kPx4, "rollrate");
  ASSERT_NE(loop, nullptr);
  commander_.set_gains(1, *loop, {.p = 0.18, .i = {}, .d = {}}, now_, done());
  const Outcome outcome = finish();
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.parameters.size(), 3U);
  EXPECT_EQ(vehicle_.param_sets.size(), 1U);
  EXPECT_FLOAT_EQ(static_cast<float>(vehicle_.params["MC_ROLLRATE_P"].value), 0.18F);
}

TEST_F(VehicleCommanderTest, RefusesAGainThatTheLoopDoesNotHave) {
  meet();
  const GainMap map = GainMap::load(CAS_SOURCE_DIR "/config/gains.yaml");
  commander_.set_gains(1, *map.find(Autopilot::kPx4, "roll"), {.p = 6.0, .i = 0.1, .d = 0.1}, now_,
                       done());
  const Outcome outcome = finish();
  EXPECT_EQ(outcome.verdict, Verdict::kRefused);
  EXPECT_EQ(outcome.message, "loop roll has no I and no D gain; it has P");
  EXPECT_TRUE(vehicle_.param_sets.empty());
}

TEST_F(VehicleCommanderTest, AsksANewVehicleForItsVersionAndHome) {
  VehicleCommander curious({}, [this](std::span<const std::uint8_t> bytes) {
    parser_.feed(bytes, [this](const mav::PacketView& packet) { vehicle_.handle(packet, now_); });
  });
  vehicle_.say_heartbeat(now_);
  mav::PacketParser parser(mavlink::common::table());
  for (int i = 0; i < 200; ++i, now_ += 5ms) {
    while (const auto packet = vehicle_.take(now_)) {
      parser.feed(packet->view(),
                  [&](const mav::PacketView& view) { curious.on_packet(kLink, view, now_); });
    }
  }
  ASSERT_EQ(vehicle_.commands.size(), 2U);
  EXPECT_EQ(vehicle_.commands[0].param1, 148.0F);
  EXPECT_EQ(vehicle_.commands[1].param1, 242.0F);
}

}  // namespace
}  // namespace cas::casd
