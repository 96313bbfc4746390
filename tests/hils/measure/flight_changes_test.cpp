// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/flight_changes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "casd/packet/own_station.hpp"
#include "casd/station/gain_map.hpp"
#include "casd/tlog/tlog_files.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/report/change_table.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/param_set.hpp"
#include "mavlink/common/param_value.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using namespace mavlink::common;  // NOLINT: the test speaks MAVLink
using nlohmann::json;

std::string text_of(const FlightChanges& changes) {
  Document report;
  add_changes(changes, "", report);
  return write_text(report);
}

/// To vehicle 1.
CommandLong command_of(MavCmd command) { return {.target_system = 1, .command = command}; }

CommandLong gps_off() {
  CommandLong message = command_of(MavCmd::kInjectFailure);
  message.param1 = 4;
  message.param2 = 1;
  return message;
}

ParamSet wish_of(const char* name) {
  ParamSet message{.target_system = 1};
  mav::set_text(message.param_id, name);
  return message;
}

/// Sets P of the loop for the position to 0.6.
FlightStep softer(const std::string& name = {}) {
  FlightStep step{.kind = StepKind::kSetGain, .name = name};
  step.loop = "position";
  step.p = 0.6;
  return step;
}

/// A flight log that the test writes, of a vehicle whose flight goes from 10 s to 60 s.
class FlightChangesTest : public testing::Test {
 protected:
  FlightChangesTest() {
    record_.system = 1;
    record_.flight_tlog = folder_ / "flight.tlog";
    record_.log_clock.add(kEpoch_us, 0);
    add_stage({.kind = StepKind::kArm}, 10, 11);
    add_stage({.kind = StepKind::kHold}, 11, 60);
  }

  void add_stage(FlightStep step, int begin_s, int end_s) {
    record_.stages.push_back({.step = std::move(step),
                              .begin = base::SimTime(std::chrono::seconds(begin_s)),
                              .end = base::SimTime(std::chrono::seconds(end_s)),
                              .accepted = base::SimTime(std::chrono::seconds(begin_s))});
  }

  template <class Message>
  void say(double time_s, mav::Encoder& who, const Message& message) {
    casd::append_tlog_record(static_cast<std::uint64_t>(kEpoch_us + std::llround(time_s * 1e6)),
                             who(message), log_);
  }
  void tell(double time_s, const std::string& name, float value) {
    ParamValue message;
    mav::set_text(message.param_id, name);
    message.param_type = MavParamType::kReal32;
    message.param_value = value;
    say(time_s, vehicle_, message);
  }
  void ask(double time_s, const std::string& method, const json& params, std::uint8_t system = 1) {
    record_.outside_calls.push_back({.log_us = kEpoch_us + std::llround(time_s * 1e6),
                                     .client = "unix:uid 1000",
                                     .method = method,
                                     .params = params.dump(),
                                     .system = system});
  }

  FlightChanges read(bool own_station = false) {
    std::ofstream(record_.flight_tlog, std::ios::binary)
        .write(reinterpret_cast<const char*>(log_.data()),
               static_cast<std::streamsize>(log_.size()));
    const auto gains = casd::GainMap::load(test::source_dir() + "/config/gains.yaml");
    return flight_changes(record_, gains, own_station);
  }

  static constexpr std::int64_t kEpoch_us = 1'700'000'000'000'000;
  test::TemporaryFolder folder_;
  RunRecord record_;
  std::vector<std::uint8_t> log_;
  mav::Encoder vehicle_{mav::Source{1, 1}};
  mav::Encoder ground_{mav::Source{255, 190}};
};

TEST_F(FlightChangesTest, AValueThatStaysIsNoChange) {
  tell(12, "MPC_XY_P", 0.95F);
  tell(20, "MPC_XY_P", 0.95F);
  const FlightChanges changes = read();
  EXPECT_TRUE(changes.parameters.empty());
  EXPECT_FALSE(changes.from_outside());
  EXPECT_EQ(text_of(changes), "");
}

TEST_F(FlightChangesTest, NamesLoopOldAndNewAndWhoHadCasdSetAGain) {
  tell(12, "MPC_XY_VEL_P_ACC", 1.5F);
  ask(20.3, "gain.set", {{"loop", "velocity"}, {"p", 1.2}});
  tell(20.1, "MPC_XY_VEL_P_ACC", 1.2F);
  const FlightChanges changes = read();
  ASSERT_EQ(changes.parameters.size(), 1U);
  const ParameterChange& change = changes.parameters[0];
  EXPECT_NEAR(change.time_s, 20.1, 1e-6);
  EXPECT_EQ(change.loop, "velocity P");
  EXPECT_EQ(change.by, "casd's command port (unix:uid 1000)");
  ASSERT_TRUE(change.before.has_value());
  EXPECT_FLOAT_EQ(static_cast<float>(*change.before), 1.5F);
  EXPECT_TRUE(changes.from_outside());
  EXPECT_TRUE(changes.acts.empty()) << "the table of parameters has it";
  EXPECT_NE(text_of(changes).find("1.5 -> 1.2"), std::string::npos) << text_of(changes);
  nlohmann::ordered_json summary;
  add_changes(changes, summary);
  EXPECT_EQ(summary.at("from_outside"), true);
  EXPECT_EQ(summary.at("changes").at(0).at("parameter"), "MPC_XY_VEL_P_ACC");
}

TEST_F(FlightChangesTest, AStepOfTheScenarioIsNobodyFromOutside) {
  add_stage(softer("softer"), 30, 31);
  tell(12, "MPC_XY_P", 0.95F);
  tell(30.5, "MPC_XY_P", 0.6F);
  const FlightChanges changes = read();
  ASSERT_EQ(changes.parameters.size(), 1U);
  EXPECT_EQ(changes.parameters[0].by, "scenario, step 'softer'");
  EXPECT_FALSE(changes.from_outside());
}

TEST_F(FlightChangesTest, AnotherValueThanTheStepsIsNotTheSteps) {
  add_stage(softer(), 30, 31);
  tell(12, "MPC_XY_P", 0.95F);
  tell(30.5, "MPC_XY_P", 0.7F);
  EXPECT_EQ(read().parameters.at(0).by, "the vehicle itself");
}

TEST_F(FlightChangesTest, AGroundStationThatSetsAParameterIsNamed) {
  const ParamSet wish = wish_of("MC_ROLL_P");
  say(20, ground_, wish);
  tell(20.1, "MC_ROLL_P", 6.0F);  // first report: the old value is unknown
  tell(25, "MC_ROLL_P", 7.0F);
  const FlightChanges changes = read();
  ASSERT_EQ(changes.parameters.size(), 2U);
  EXPECT_EQ(changes.parameters[0].by, "ground station 255/190");
  EXPECT_FALSE(changes.parameters[0].before.has_value());
  EXPECT_TRUE(changes.parameters[0].from_outside);
  EXPECT_FALSE(changes.parameters[1].from_outside) << "a wish is answered once";
}

TEST_F(FlightChangesTest, ATrajectorysOwnParametersAreLeftOut) {
  FlightStep step{.kind = StepKind::kTrajectory};
  step.params = {{"TRJ_SHAPE", 1.0}};
  add_stage(step, 30, 50);
  tell(12, "TRJ_SHAPE", 0.0F);
  tell(30, "TRJ_SHAPE", 1.0F);
  EXPECT_TRUE(read().parameters.empty());
}

TEST_F(FlightChangesTest, AFailureThatAStationInjectsIsAnAct) {
  say(30, ground_, gps_off());
  const FlightChanges changes = read();
  ASSERT_EQ(changes.acts.size(), 1U);
  EXPECT_EQ(changes.acts[0].what, "command 420 (failure gps off)");
  EXPECT_TRUE(changes.from_outside());
}

TEST_F(FlightChangesTest, AFailureCountsAlsoBeforeTheFlight) {
  say(5, ground_, gps_off());
  ask(6, "vehicle.command", {{"command", 420}, {"params", {4, 1, 0}}});
  const FlightChanges changes = read();
  ASSERT_EQ(changes.acts.size(), 2U);
  EXPECT_NEAR(changes.acts[0].time_s, 5, 1e-6);
  EXPECT_NEAR(changes.acts[1].time_s, 6, 1e-6);
}

TEST_F(FlightChangesTest, CommandsOfOthersDuringTheFlightAreActs) {
  const CommandLong land = command_of(MavCmd::kNavLand);
  CommandLong question = land;
  question.command = MavCmd::kRequestMessage;
  CommandLong of_another = land;
  of_another.target_system = 2;
  say(5, ground_, land);  // before the flight
  say(20, ground_, question);
  say(21, ground_, of_another);
  say(30, ground_, land);
  say(31, ground_, land);
  ask(40, "vehicle.goto", {{"north_m", 1}});
  ask(41, "vehicle.message_interval", {{"message", "ATTITUDE"}});
  ask(42, "vehicle.command", {{"command", 512}});
  ask(43, "vehicle.hold", json::object(), 2);
  const FlightChanges changes = read();
  ASSERT_EQ(changes.acts.size(), 2U);
  EXPECT_EQ(changes.acts[0].what, "command 21 (land)");
  EXPECT_EQ(changes.acts[0].times, 2U);
  EXPECT_NEAR(changes.acts[0].time_s, 30, 1e-6);
  EXPECT_EQ(changes.acts[1].what, R"(vehicle.goto {"north_m":1})");
  EXPECT_TRUE(changes.from_outside());
}

TEST_F(FlightChangesTest, WhatEndedAFlightIsAnAct) {
  say(61, ground_, command_of(MavCmd::kNavLand));
  EXPECT_TRUE(read().acts.empty()) << "the flight was over";
  record_.flight_failure = "the vehicle was disarmed during hold";
  EXPECT_EQ(read().acts.size(), 1U);
}

TEST_F(FlightChangesTest, WhatEndedAFlightInItsFirstStepIsAnAct) {
  record_.under_way = record_.stages.front();
  record_.stages.clear();
  record_.flight_failure = "the vehicle was disarmed before it took off, during step 1 (arm)";
  say(10.5, ground_, command_of(MavCmd::kComponentArmDisarm));
  ASSERT_EQ(read().acts.size(), 1U);
}

TEST_F(FlightChangesTest, ANameFromTheWireIsFitForATerminalAndForJson) {
  tell(12, "A\x1b[31m\xff", 1.0F);
  tell(13, "A\x1b[31m\xff", 2.0F);
  const FlightChanges changes = read();
  ASSERT_EQ(changes.parameters.size(), 1U);
  EXPECT_EQ(changes.parameters[0].parameter, "A?[31m?");
}

TEST_F(FlightChangesTest, AWishThatNobodyAnsweredIsForgotten) {
  const ParamSet wish = wish_of("MPC_XY_P");
  tell(12, "MPC_XY_P", 0.95F);
  say(13, ground_, wish);
  tell(40, "MPC_XY_P", 0.6F);
  const FlightChanges changes = read();
  ASSERT_EQ(changes.parameters.size(), 1U);
  EXPECT_EQ(changes.parameters[0].by, "the vehicle itself");
}

TEST_F(FlightChangesTest, WhatCasdsOwnStationSaysIsKnownFromItsCalls) {
  mav::Encoder casd(casd::kOwnStation);
  const CommandLong land = command_of(MavCmd::kNavLand);
  const ParamSet wish = wish_of("MPC_XY_P");
  add_stage(softer(), 30, 31);
  tell(12, "MPC_XY_P", 0.95F);
  say(30, casd, wish);
  tell(30.1, "MPC_XY_P", 0.6F);
  say(30.5, casd, land);
  const FlightChanges changes = read();
  EXPECT_TRUE(changes.acts.empty());
  ASSERT_EQ(changes.parameters.size(), 1U);
  EXPECT_EQ(changes.parameters[0].by, "scenario, step 'setgain'");
  EXPECT_FALSE(changes.from_outside());
}

TEST_F(FlightChangesTest, CentredSticksOfTheScenariosOwnStationAreNoAct) {
  say(30, ground_, ManualControl{.target = 1});
  EXPECT_TRUE(read(true).acts.empty());
  EXPECT_EQ(read(false).acts.size(), 1U);
}

TEST_F(FlightChangesTest, WhatWasDoneToTheSimulatorTouchesEveryVehicleWheneverItWas) {
  add_stage({.kind = StepKind::kArm}, 10, 11);
  const json journal{{"calls",
                      {{{"unix_us", kEpoch_us},
                        {"time_s", 3.5},
                        {"client", "unix:uid 0"},
                        {"method", "sim.reset"},
                        {"params", json::object()}}}},
                     {"forgotten", 0}};
  record_.outside_calls = outside_calls(journal, "unix:uid 0 (hils-7)", "hilsim's control socket");
  const FlightChanges changes = read();
  ASSERT_EQ(changes.acts.size(), 1U);
  EXPECT_EQ(changes.acts[0].by, "hilsim's control socket (unix:uid 0)");
  EXPECT_EQ(changes.acts[0].what, "sim.reset");
  EXPECT_EQ(changes.acts[0].time_s, 3.5);
  EXPECT_TRUE(changes.from_outside());
}

TEST_F(FlightChangesTest, CallsThatTheSimulatorHasForgottenTouchTheRun) {
  const json all{{"calls", json::array()}, {"forgotten", 0}};
  EXPECT_FALSE(forgotten_calls(all, "hilsim's control socket"));
  const json some{{"calls", json::array()}, {"forgotten", 7}};
  const auto older = forgotten_calls(some, "hilsim's control socket");
  ASSERT_TRUE(older);
  record_.outside_calls = {*older};
  const FlightChanges changes = read();
  ASSERT_EQ(changes.acts.size(), 1U);
  EXPECT_EQ(changes.acts[0].by, "hilsim's control socket (somebody)");
  EXPECT_EQ(changes.acts[0].what, "calls that are no longer listed: 7");
  EXPECT_TRUE(changes.from_outside());
}

TEST(OutsideCalls, AreThoseThatHilsDidNotMake) {
  const auto call = [](const std::string& client, const std::string& method) {
    return json{{"unix_us", 5},
                {"client", client},
                {"method", method},
                {"params", json::object()},
                {"vehicle", 1}};
  };
  const std::string own = "unix:uid 0 (hils-7)";
  const json journal{{"calls",
                      {call(own, "vehicle.arm"), call("unix:uid 0", "vehicle.land"),
                       call(own, "vehicle.land"), call("unix:uid 0 (hils-8)", "gain.set")}}};
  const auto others = outside_calls(journal, own);
  ASSERT_EQ(others.size(), 2U) << "one landing of two was hils's own";
  EXPECT_EQ(others[0].method, "vehicle.land");
  EXPECT_EQ(others[1].method, "gain.set");
}

}  // namespace
}  // namespace cas::hils
