// SPDX-License-Identifier: BSD-3-Clause
#include <bit>

#include "tests/casd/station/commander_fixture.hpp"
#include "tests/support/paths.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using test::VehicleCommanderTest;

TEST_F(VehicleCommanderTest, SetsAParameterAfterAskingForItsType) {
  vehicle_.params["MC_ROLL_P"] = {.value = 6.5};
  meet();
  const Outcome outcome = ask(&VehicleCommander::set_param, "MC_ROLL_P", 7.2);
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(vehicle_.param_reads, 1);
  EXPECT_FLOAT_EQ(static_cast<float>(outcome.parameters.at("MC_ROLL_P")), 7.2F);
  EXPECT_TRUE(ask(&VehicleCommander::set_param, "MC_ROLL_P", 7.3).ok());
  EXPECT_EQ(vehicle_.param_reads, 1);  // the type is known now
}

TEST_F(VehicleCommanderTest, SendsPx4IntegersAsBytes) {
  vehicle_.params["SYS_HITL"] = {.value = 0, .type = MavParamType::kInt32};
  meet();
  EXPECT_TRUE(ask(&VehicleCommander::set_param, "SYS_HITL", 1).ok());
  EXPECT_EQ(std::bit_cast<std::uint32_t>(vehicle_.param_sets.at(0).param_value), 1U);
  EXPECT_EQ(vehicle_.params["SYS_HITL"].value, 1);
}

TEST_F(VehicleCommanderTest, SendsArduPilotIntegersAsNumbers) {
  vehicle_.autopilot = MavAutopilot::kArdupilotmega;
  vehicle_.params["FRAME_TYPE"] = {.value = 0, .type = MavParamType::kInt8};
  meet();
  EXPECT_TRUE(ask(&VehicleCommander::set_param, "FRAME_TYPE", -3).ok());
  EXPECT_EQ(vehicle_.param_sets.at(0).param_value, -3.0F);
  EXPECT_EQ(vehicle_.params["FRAME_TYPE"].value, -3);
}

TEST_F(VehicleCommanderTest, SetsWhatLetsAVehicleArmOnlyInHilOrWithConsent) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;
  vehicle_.params = {{"CBRK_SUPPLY_CHK", {.value = 0, .type = MavParamType::kInt32}},
                     {"SYS_HITL", {.value = 0, .type = MavParamType::kInt32}},
                     {"MC_ROLL_P", {.value = 6.5}}};
  meet();
  const auto set = [this](const char* name, double value, bool not_hil = false) {
    commander_.set_param(1, name, value, now_, done(), not_hil);
    return finish().kind;
  };
  EXPECT_EQ(set("CBRK_SUPPLY_CHK", 894281), OutcomeKind::kInterlock);
  EXPECT_EQ(set("CBRK_SUPPLY_CHK", 894281, true), OutcomeKind::kInterlock);  // half a consent
  EXPECT_TRUE(vehicle_.param_sets.empty());
  EXPECT_EQ(set("SYS_HITL", 1), OutcomeKind::kAccepted);
  EXPECT_EQ(set("MC_ROLL_P", 7), OutcomeKind::kAccepted);
  const GainLoop arming{.name = "arming", .p = "CBRK_SUPPLY_CHK", .i = {}, .d = {}};
  commander_.set_gains(1, arming, {.p = 894281, .i = {}, .d = {}}, now_, done());
  EXPECT_EQ(finish().kind, OutcomeKind::kInterlock);
  commander_.set_commanding(1, true, false);
  EXPECT_EQ(set("CBRK_SUPPLY_CHK", 894281), OutcomeKind::kInterlock);
  EXPECT_EQ(set("CBRK_SUPPLY_CHK", 894281, true), OutcomeKind::kAccepted);
}

TEST_F(VehicleCommanderTest, RepeatsNoSetOfWhatLetsAVehicleArmOnceItIsNotInHil) {
  vehicle_.params = {{"CBRK_SUPPLY_CHK", {.value = 0, .type = MavParamType::kInt32}}};
  meet();
  ASSERT_TRUE(ask(&VehicleCommander::read_param, "CBRK_SUPPLY_CHK").ok());
  vehicle_.script.deaf_for = 1;
  commander_.set_param(1, "CBRK_SUPPLY_CHK", 894281, now_, done());
  vehicle_.script.deaf_for = 0;
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;
  vehicle_.say_heartbeat(now_);
  EXPECT_EQ(finish().kind, OutcomeKind::kInterlock);
  EXPECT_EQ(vehicle_.param_sets.size(), 1U) << "the first one, which it missed";
  EXPECT_EQ(vehicle_.params["CBRK_SUPPLY_CHK"].value, 0);
}

TEST_F(VehicleCommanderTest, SaysWhichValueTheVehicleKeeps) {
  vehicle_.params["MC_ROLL_P"] = {.value = 6.5, .high = 12};
  meet();
  const Outcome outcome = ask(&VehicleCommander::set_param, "MC_ROLL_P", 99);
  EXPECT_EQ(outcome.kind, OutcomeKind::kRefused);
  EXPECT_EQ(outcome.parameters.at("MC_ROLL_P"), 12);
  EXPECT_NE(outcome.message.find("keeps MC_ROLL_P = 12 (asked: 99)"), std::string::npos)
      << outcome.message;
}

TEST_F(VehicleCommanderTest, RefusesAFractionInAnIntegerParameter) {
  vehicle_.params["SYS_HITL"] = {.value = 0, .type = MavParamType::kInt32};
  meet();
  EXPECT_EQ(ask(&VehicleCommander::set_param, "SYS_HITL", 0.5).kind, OutcomeKind::kInvalid);
  EXPECT_TRUE(vehicle_.param_sets.empty());
}

TEST_F(VehicleCommanderTest, RepeatsALostParamSet) {
  vehicle_.params["MC_ROLL_P"] = {.value = 6.5};
  meet();
  vehicle_.script.deaf_for = 3;
  EXPECT_TRUE(ask(&VehicleCommander::set_param, "MC_ROLL_P", 7).ok());
  EXPECT_EQ(vehicle_.params["MC_ROLL_P"].value, 7);
}

TEST_F(VehicleCommanderTest, GivesUpOnAParameterThatTheVehicleDoesNotHave) {
  meet();
  EXPECT_EQ(ask(&VehicleCommander::read_param, "NOPE").kind, OutcomeKind::kTimeout);
  EXPECT_EQ(vehicle_.param_reads, 5);
}

TEST_F(VehicleCommanderTest, ListsAllParametersAndFetchesTheLostOnes) {
  for (int i = 0; i < 40; ++i) {
    vehicle_.params["P" + std::to_string(100 + i)] = {.value = i * 1.0};
  }
  vehicle_.lost_in_list = {"P103", "P139", "P117"};
  meet();
  const Outcome outcome = ask(&VehicleCommander::list_params);
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.parameters.size(), 40U);
  EXPECT_EQ(outcome.parameters.at("P139"), 39);
  EXPECT_EQ(vehicle_.param_reads, 3);
}

TEST_F(VehicleCommanderTest, EndsAListThatNeverComes) {
  meet();
  EXPECT_EQ(ask(&VehicleCommander::list_params).kind, OutcomeKind::kTimeout);
}

TEST_F(VehicleCommanderTest, SetsTheGivenGainsAndAnswersWithAll) {
  vehicle_.params["MC_ROLLRATE_P"] = {.value = 0.15};
  vehicle_.params["MC_ROLLRATE_I"] = {.value = 0.2};
  vehicle_.params["MC_ROLLRATE_D"] = {.value = 0.003};
  meet();
  const GainMap map = GainMap::load(cas::test::source_dir() + "/config/gains.yaml");
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
  const GainMap map = GainMap::load(cas::test::source_dir() + "/config/gains.yaml");
  commander_.set_gains(1, *map.find(Autopilot::kPx4, "roll"), {.p = 6.0, .i = 0.1, .d = 0.1}, now_,
                       done());
  const Outcome outcome = finish();
  EXPECT_EQ(outcome.kind, OutcomeKind::kRefused);
  EXPECT_EQ(outcome.message, "loop roll has no I and no D gain; it has P");
  EXPECT_TRUE(vehicle_.param_sets.empty());
}

}  // namespace
}  // namespace cas::casd
