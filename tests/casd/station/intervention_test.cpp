// SPDX-License-Identifier: BSD-3-Clause
// Commands to a vehicle from stations other than casd's own.
#include "casd/packet/intervention.hpp"

#include "tests/casd/packets.hpp"
#include "tests/casd/station/commander_fixture.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using namespace std::chrono_literals;

constexpr mav::Source kStation{255, 190};
constexpr mav::Source kVehicle{1, 1};

CommandLong command_to_vehicle(MavCmd id, float param1 = 0, float param2 = 0) {
  CommandLong command = test::command_to(1, 1);
  command.command = id;
  command.param1 = param1;
  command.param2 = param2;
  return command;
}

CommandAck ack_to(mav::Source station, MavCmd command) {
  return {
      .command = command, .target_system = station.system, .target_component = station.component};
}

class Overheard : public test::VehicleCommanderTest {
 protected:
  template <class Message>
  void hear(const Message& message, mav::Source from = kStation) {
    const mav::PacketBuffer buffer = test::packet(message, from);
    commander_.on_packet(test::kLink, test::view(buffer), now_);
  }
  /// "command 400 (disarm) !, MANUAL_CONTROL"
  std::string heard() const {
    std::string all;
    for (const Intervention& each : commander_.hands(1).interventions.all()) {
      all += (all.empty() ? "" : ", ") + each.act.what + (each.act.disarms ? " !" : "");
    }
    return all;
  }
};

TEST_F(Overheard, CommandsThatDisarmAreToldFromOthers) {
  meet();
  hear(command_to_vehicle(MavCmd::kComponentArmDisarm));
  hear(command_to_vehicle(MavCmd::kComponentArmDisarm, 1));
  hear(command_to_vehicle(MavCmd::kDoFlighttermination, 1));
  hear(command_to_vehicle(MavCmd::kNavReturnToLaunch));
  CommandInt placed;
  placed.target_system = placed.target_component = 1;
  placed.command = MavCmd::kNavLand;
  hear(placed);
  EXPECT_EQ(heard(),
            "command 400 (disarm) !, command 400 (arm), command 185 (end the flight) !, "
            "command 20 (return to launch), command 21 (land)");
  const Intervention& first = commander_.hands(1).interventions.all().front();
  EXPECT_EQ(first.by, kStation);
  EXPECT_EQ(first.link, test::kLink);
}

TEST_F(Overheard, WhatIsNoPlainArmingMayDisarm) {
  meet();
  hear(command_to_vehicle(MavCmd::kComponentArmDisarm, 0.4F));
  EXPECT_EQ(heard(), "command 400 (disarm) !") << "PX4 rounds it to 0";
}

TEST_F(Overheard, SwitchesGivenAsCommandsDisarmToo) {
  constexpr auto kDoAuxFunction = static_cast<MavCmd>(218);
  meet();
  hear(command_to_vehicle(kDoAuxFunction, 153, 2));
  hear(command_to_vehicle(kDoAuxFunction, 153, 0));
  EXPECT_EQ(heard(), "command 218, command 218 (disarm) !");
}

TEST_F(Overheard, SticksAndModesCountWithTheirAddressee) {
  meet();
  hear(SetMode{.target_system = 1});
  ManualControl sticks{.target = 1};
  hear(sticks);
  hear(sticks);
  sticks.target = 2;
  hear(sticks);
  EXPECT_EQ(heard(), "SET_MODE, MANUAL_CONTROL");
  EXPECT_EQ(commander_.hands(1).interventions.all().back().times, 2U);
}

TEST_F(Overheard, QuestionsAndThoseToOthersDoNotCount) {
  meet();
  hear(command_to_vehicle(MavCmd::kRequestMessage));
  hear(command_to_vehicle(MavCmd::kSetMessageInterval));
  hear(Heartbeat{});
  CommandLong of_gimbal = command_to_vehicle(MavCmd::kComponentArmDisarm);
  of_gimbal.target_component = 154;
  hear(of_gimbal);
  hear(command_to_vehicle(MavCmd::kNavLand), kVehicle);
  EXPECT_EQ(heard(), "");
  of_gimbal.target_component = 0;
  hear(of_gimbal);
  EXPECT_EQ(heard(), "command 400 (disarm) !") << "to all components";
}

TEST_F(Overheard, OfParametersThoseCountThatSayWhenTheAutopilotDisarms) {
  meet();
  ParamSet set;
  set.target_system = set.target_component = 1;
  for (const char* parameter : {"MPC_XY_P", "COM_DISARM_PRFLT", "DISARM_DELAY"}) {
    mav::set_text(set.param_id, parameter);
    hear(set);
  }
  EXPECT_EQ(heard(), "PARAM_SET COM_DISARM_PRFLT, PARAM_SET DISARM_DELAY");
}

TEST_F(Overheard, AnswersToOthersTellOfCommandsThatWentAnotherWay) {
  meet();
  hear(ack_to({254, 190}, MavCmd::kComponentArmDisarm), kVehicle);
  hear(ack_to(kStation, MavCmd::kRequestMessage), kVehicle);
  EXPECT_EQ(heard(), "");
  hear(ack_to(kStation, MavCmd::kComponentArmDisarm), kVehicle);
  EXPECT_EQ(heard(), "command 400 (arm or disarm), by the vehicle's answer to it !");
  EXPECT_EQ(commander_.hands(1).interventions.all().front().by, kStation);
}

TEST_F(Overheard, ADisarmIsNotFollowedByCasdsOwnArmingThatIsUnderWay) {
  meet();
  vehicle_.script.answers = 0;
  commander_.arm(1, {}, now_, done());
  run_for(100ms);
  const std::size_t sent = vehicle_.commands.size();
  ASSERT_GT(sent, 0U);
  hear(command_to_vehicle(MavCmd::kComponentArmDisarm));
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->kind, OutcomeKind::kRefused);
  EXPECT_EQ(outcome_->message,
            "MAV_CMD 400 (arm or disarm) was overtaken by 255/190: command 400 (disarm)");
  run_for(5s);
  EXPECT_EQ(vehicle_.commands.size(), sent) << "it was armed again";
}

TEST_F(Overheard, ADisarmEndsAllThatMaySpinMotors) {
  meet();
  vehicle_.script.answers = 0;
  std::vector<std::string> ended;
  const auto note = [&](const Outcome& outcome) { ended.push_back(outcome.message); };
  const VehicleCommand start{.id = MavCmd::kMissionStart};
  commander_.command(1, start, false, now_, note);
  commander_.command(1, start, false, now_, note);  // waits
  run_for(100ms);
  const std::size_t sent = vehicle_.commands.size();
  hear(command_to_vehicle(MavCmd::kDoFlighttermination, 1));
  EXPECT_EQ(ended, std::vector<std::string>(
                       2, "MAV_CMD 300 was overtaken by 255/190: command 185 (end the flight)"));
  run_for(5s);
  EXPECT_EQ(vehicle_.commands.size(), sent) << "a mission was started behind a disarm";
}

// A vehicle that waits in its takeoff mode takes off as soon as it is armed.
TEST_F(Overheard, ADisarmEndsATakeoffThatIsUnderWay) {
  meet();
  vehicle_.say(HomePosition{.altitude = 488'000}, now_);
  run_for(50ms);
  vehicle_.script.answers = 0;
  commander_.takeoff(1, 2.5, now_, done());
  hear(command_to_vehicle(MavCmd::kComponentArmDisarm));
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->message,
            "MAV_CMD 22 (take off) was overtaken by 255/190: command 400 (disarm)");
}

class OverheardBefore : public Overheard, public testing::WithParamInterface<MavAutopilot> {};

TEST_P(OverheardBefore, ATakeoffDoesNotBeginAfterADisarm) {
  vehicle_.params["MIS_TAKEOFF_ALT"] = {.value = 10};
  vehicle_.autopilot = GetParam();
  meet();
  commander_.takeoff(1, 2.5, now_, done());  // the height or the mode comes first
  hear(command_to_vehicle(MavCmd::kComponentArmDisarm));
  EXPECT_EQ(finish().message, "MAV_CMD 22 (take off) was overtaken by a disarm");
  run_for(1s);
  for (const CommandLong& sent : vehicle_.commands) {
    EXPECT_NE(sent.command, MavCmd::kNavTakeoff);
  }
  EXPECT_EQ(vehicle_.params["MIS_TAKEOFF_ALT"].value, 10);
}

INSTANTIATE_TEST_SUITE_P(Autopilots, OverheardBefore,
                         testing::Values(MavAutopilot::kPx4, MavAutopilot::kArdupilotmega));

TEST_F(Overheard, SoDoesCasdsOwnEndOfTheFlight) {
  meet();
  vehicle_.script.answers = 0;
  commander_.command(1, {.id = MavCmd::kMissionStart}, false, now_, done());
  commander_.command(1, {.id = MavCmd::kDoFlighttermination, .params = {1}}, false, now_,
                     [](const Outcome&) {});
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->message, "MAV_CMD 300 was overtaken by a newer request to disarm");
}

TEST_F(Overheard, IsRememberedOfAVehicleThatWasForgotten) {
  meet();
  hear(command_to_vehicle(MavCmd::kComponentArmDisarm));
  commander_.forget(bit(test::kLink));
  ASSERT_EQ(commander_.find(1), nullptr);
  meet();
  EXPECT_EQ(heard(), "command 400 (disarm) !");
}

TEST(Interventions, KeepTheDisarmAmongManyOthers) {
  Interventions all;
  all.add({.by = kStation, .act = {.what = "disarm", .disarms = true}});
  for (std::uint8_t i = 0; i < 50; ++i) {
    all.add({.by = {255, i}, .act = {.what = "MANUAL_CONTROL"}});
  }
  EXPECT_EQ(all.all().size(), Interventions::kMost);
  EXPECT_TRUE(all.all().front().act.disarms);
}

}  // namespace
}  // namespace cas::casd
