// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/vehicle_methods.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "base/rpc/client.hpp"
#include "casd/port/call_journal.hpp"
#include "tests/casd/port/command_port_fixture.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::casd {
namespace {

using base::rpc::CallError;
using base::rpc::Client;
using mavlink::common::MavModeFlag;
using mavlink::common::MavResult;
using nlohmann::json;
using test::CommandPortFixture;
using testing::HasSubstr;

class VehicleMethodsTest : public testing::Test {
 protected:
  json call(const std::string& method, const json& params = json::object()) {
    if (!client_) {
      fixture_.start();
      client_.emplace(fixture_.address());
    }
    return client_->call(method, params);
  }
  /// The error that a call ends with.
  CallError error(const std::string& method, const json& params = json::object()) {
    try {
      const json result = call(method, params);
      ADD_FAILURE() << method << " answered " << result;
    } catch (const CallError& caught) {
      return caught;
    }
    return CallError(0, "", "");
  }

  CommandPortFixture fixture_;
  std::optional<Client> client_;
};

TEST_F(VehicleMethodsTest, AnswersArmAfterTheAcknowledgement) {
  json armed = call("vehicle.arm");
  EXPECT_GT(armed.at("at_s"), 0.0);
  armed.erase("at_s");
  EXPECT_EQ(armed, (json{{"vehicle", 1}, {"result", "ACCEPTED"}}));
  fixture_.stop();
  EXPECT_EQ(fixture_.vehicle().commands.size(), 1U);
}

TEST_F(VehicleMethodsTest, ReportsARefusalWithResultAndText) {
  fixture_.vehicle().script.result = MavResult::kDenied;
  fixture_.vehicle().script.text = "Preflight Fail: compass";
  const CallError refused = error("vehicle.arm");
  EXPECT_EQ(refused.code(), -32000);
  const json data = json::parse(refused.data_json());
  EXPECT_EQ(data.at("result"), "DENIED");
  EXPECT_EQ(data.at("result_code"), 2);
  EXPECT_EQ(data.at("status_texts"), json::array({"Preflight Fail: compass"}));
}

TEST_F(VehicleMethodsTest, ReportsSilenceAsTimeout) {
  fixture_.vehicle().script.answers = 0;
  EXPECT_EQ(error("vehicle.land").code(), -32001);
}

TEST_F(VehicleMethodsTest, ReportsTheInterlock) {
  fixture_.vehicle().base_mode = MavModeFlag::kCustomModeEnabled;
  const CallError refused = error("vehicle.arm", {{"not_hil", true}});
  EXPECT_EQ(refused.code(), -32004);
  EXPECT_THAT(std::string(refused.what()), HasSubstr("allow_not_hil"));
  fixture_.stop();
  EXPECT_TRUE(fixture_.vehicle().commands.empty());
}

TEST_F(VehicleMethodsTest, ArmsOutsideHilOnlyByConsentOfBoth) {
  fixture_.vehicle().base_mode = MavModeFlag::kCustomModeEnabled;
  fixture_.allow_not_hil();
  EXPECT_EQ(error("vehicle.arm").code(), -32004);
  EXPECT_EQ(call("vehicle.arm", {{"not_hil", true}}).at("result"), "ACCEPTED");
}

TEST_F(VehicleMethodsTest, MovesTheSticksOfAVehicleInHilOnly) {
  EXPECT_EQ(call("vehicle.manual_control", {{"pitch", 0.25}, {"roll", -1}, {"throttle", 0.5}}),
            (json{{"vehicle", 1}, {"result", "SENT"}}));
  EXPECT_EQ(call("vehicle.manual_control", {{"yaw", 1}, {"buttons", 3}}).at("result"), "SENT");
  fixture_.stop();
  ASSERT_EQ(fixture_.vehicle().sticks.size(), 2U);
  const auto& first = fixture_.vehicle().sticks[0];
  EXPECT_EQ(first.target, 1);
  EXPECT_EQ(first.x, 250);
  EXPECT_EQ(first.y, -1000);
  EXPECT_EQ(first.z, 500);
  EXPECT_EQ(first.r, 0);
  EXPECT_EQ(fixture_.vehicle().sticks[1].r, 1000);
  EXPECT_EQ(fixture_.vehicle().sticks[1].buttons, 3);
  EXPECT_EQ(fixture_.audit().size(), 1U) << "sticks come many times a second";
}

TEST_F(VehicleMethodsTest, KeepsTheSticksOfARealVehicle) {
  fixture_.vehicle().base_mode = MavModeFlag::kCustomModeEnabled;
  EXPECT_EQ(error("vehicle.manual_control", {{"throttle", 0.5}}).code(), -32004);
  fixture_.stop();
  EXPECT_TRUE(fixture_.vehicle().sticks.empty());
}

TEST_F(VehicleMethodsTest, KnowsNoVehicleSeven) {
  EXPECT_EQ(error("vehicle.arm", {{"vehicle", 7}}).code(), -32002);
}

TEST_F(VehicleMethodsTest, NeedsTheVehicleNamedWhenThereAreTwo) {
  fixture_.add_vehicle();
  EXPECT_EQ(error("vehicle.arm").code(), -32602);
  EXPECT_EQ(call("vehicle.arm", {{"vehicle", 2}}).at("vehicle"), 2);
  fixture_.stop();
  EXPECT_TRUE(fixture_.vehicle(0).commands.empty());
  EXPECT_EQ(fixture_.vehicle(1).commands.size(), 1U);
}

struct BadCase {
  const char* name;
  const char* method;
  const char* params;
};

class BadParameters : public VehicleMethodsTest, public testing::WithParamInterface<BadCase> {};

TEST_P(BadParameters, AreRefusedBeforeAnythingIsSent) {
  EXPECT_EQ(error(GetParam().method, json::parse(GetParam().params)).code(), -32602);
  fixture_.stop();
  EXPECT_TRUE(fixture_.vehicle().commands.empty());
  EXPECT_TRUE(fixture_.vehicle().param_sets.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Methods, BadParameters,
    testing::Values(BadCase{"MissingAltitude", "vehicle.takeoff", "{}"},
                    BadCase{"TextForAltitude", "vehicle.takeoff", R"({"altitude_m": "high"})"},
                    BadCase{"NegativeAltitude", "vehicle.takeoff", R"({"altitude_m": -1})"},
                    BadCase{"UnknownKey", "vehicle.arm", R"({"forse": true})"},
                    BadCase{"NumberForFlag", "vehicle.arm", R"({"force": 1})"},
                    BadCase{"VehicleZero", "vehicle.arm", R"({"vehicle": 0})"},
                    BadCase{"VehicleFraction", "vehicle.arm", R"({"vehicle": 1.5})"},
                    BadCase{"ListOfParameters", "vehicle.arm", "[1]"},
                    BadCase{"StickTooFar", "vehicle.manual_control", R"({"pitch": 1.5})"},
                    BadCase{"NoGain", "gain.set", R"({"loop": "roll"})"},
                    BadCase{"UnknownMode", "vehicle.mode", R"({"mode": "WARP"})"},
                    BadCase{"UnknownMessage", "vehicle.message_interval", R"({"message": "X"})"},
                    BadCase{"EightParams", "vehicle.command",
                            R"({"command": 400, "params": [1,2,3,4,5,6,7,8]})"}),
    [](const auto& test) { return test.param.name; });

TEST_F(VehicleMethodsTest, SetsGainsByLoop) {
  fixture_.vehicle().params = {{"MC_ROLLRATE_P", {.value = 0.15}},
                               {"MC_ROLLRATE_I", {.value = 0.2}},
                               {"MC_ROLLRATE_D", {.value = 0.003}}};
  const json gains = call("gain.set", {{"loop", "rollrate"}, {"p", 0.18}, {"d", 0.004}});
  EXPECT_EQ(gains.at("p"), 0.18);
  EXPECT_EQ(gains.at("i"), 0.2);
  EXPECT_EQ(gains.at("d"), 0.004);
  EXPECT_EQ(gains.at("parameters").at("MC_ROLLRATE_D"), 0.004);
  EXPECT_EQ(gains.at("before"), (json{{"p", 0.15}, {"d", 0.003}})) << "what was set, and no more";
  EXPECT_EQ(call("gain.set", {{"loop", "rollrate"}, {"p", 0.2}}).at("before").at("p"), 0.18);
  EXPECT_FALSE(call("gain.get", {{"loop", "rollrate"}}).contains("before"));
}

TEST_F(VehicleMethodsTest, RefusesAGainOrLoopThatIsNotThere) {
  EXPECT_EQ(error("gain.set", {{"loop", "roll"}, {"i", 1}}).code(), -32000);
  const CallError unknown = error("gain.set", {{"loop", "warp"}, {"p", 1}});
  EXPECT_EQ(unknown.code(), -32000);
  EXPECT_THAT(std::string(unknown.what()), HasSubstr("rollrate"));
  const CallError misspelt = error("gain.set", {{"loop", "velocty"}, {"p", 1}});
  EXPECT_THAT(std::string(misspelt.what()), HasSubstr("; did you mean 'velocity'?"));
}

TEST_F(VehicleMethodsTest, ListsTheLoopsOfTheAutopilot) {
  const json loops = call("gain.list").at("loops");
  EXPECT_EQ(loops.size(), 10U);
  EXPECT_EQ(loops.at(0),
            (json{{"loop", "rollrate"},
                  {"parameters",
                   {{"p", "MC_ROLLRATE_P"}, {"i", "MC_ROLLRATE_I"}, {"d", "MC_ROLLRATE_D"}}}}));
}

TEST_F(VehicleMethodsTest, ReadsWritesAndListsParameters) {
  fixture_.vehicle().params = {
      {"MC_ROLL_P", {.value = 6.5}},
      {"SYS_HITL", {.value = 1, .type = mavlink::common::MavParamType::kInt32}}};
  EXPECT_EQ(call("param.get", {{"name", "SYS_HITL"}}),
            (json{{"vehicle", 1}, {"name", "SYS_HITL"}, {"value", 1}, {"type", "INT32"}}));
  EXPECT_EQ(call("param.set", {{"name", "MC_ROLL_P"}, {"value", 7.2}}).at("value"), 7.2);
  const json list = call("param.list").at("parameters");
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list.at(0).at("name"), "MC_ROLL_P");
}

TEST_F(VehicleMethodsTest, TellsWhatIsInForceWhenAValueIsRefused) {
  fixture_.vehicle().params = {{"MC_ROLL_P", {.value = 6.5, .high = 12}}};
  const CallError refused = error("param.set", {{"name", "MC_ROLL_P"}, {"value", 99}});
  EXPECT_EQ(refused.code(), -32000);
  EXPECT_EQ(json::parse(refused.data_json()).at("parameters").at("MC_ROLL_P"), 12);
}

TEST_F(VehicleMethodsTest, TellsTheVehiclesState) {
  auto& vehicle = fixture_.vehicle();
  vehicle.custom_mode = 4U << 16 | 3U << 24;
  mavlink::common::LocalPositionNed local{.x = 1.5F, .z = -2.5F};
  vehicle.say_heartbeat(base::steady_now());
  vehicle.say(local, base::steady_now());
  vehicle.say_text("hello", base::steady_now());
  const json state = call("vehicle.state");
  EXPECT_EQ(state.at("system"), 1);
  EXPECT_EQ(state.at("autopilot"), "PX4");
  EXPECT_EQ(state.at("mode"), "HOLD");
  EXPECT_EQ(state.at("hil"), true);
  EXPECT_EQ(state.at("armed"), false);
  EXPECT_EQ(state.at("link"), "fcu");
  EXPECT_EQ(state.at("position_N").at("x_m"), 1.5);
  EXPECT_EQ(state.at("altitude_m"), 2.5);
  EXPECT_EQ(state.at("statustexts").at(0).at("text"), "hello");
}

TEST_F(VehicleMethodsTest, LeavesOutWhatTheVehicleDoesNotKnow) {
  auto& vehicle = fixture_.vehicle();
  mavlink::common::LocalPositionNed local{.z = std::numeric_limits<float>::quiet_NaN()};
  vehicle.say_heartbeat(base::steady_now());
  vehicle.say(local, base::steady_now());
  vehicle.say_text("hello", base::steady_now());
  const json state = call("vehicle.state");
  EXPECT_EQ(state.at("statustexts").size(), 1U);
  EXPECT_FALSE(state.contains("position_N"));
  EXPECT_FALSE(state.contains("altitude_m"));
}

TEST_F(VehicleMethodsTest, TellsTelemetryWithNullForWhatIsNotKnown) {
  auto& vehicle = fixture_.vehicle();
  mavlink::common::Attitude attitude{.roll = 0.1F, .yaw = std::numeric_limits<float>::quiet_NaN()};
  mavlink::common::SysStatus no_battery{.voltage_battery = 0xFFFF};
  mavlink::common::BatteryStatus battery;
  battery.voltages.fill(0xFFFF);
  battery.voltages[0] = 4000;
  battery.voltages[1] = 4100;
  battery.current_battery = 150;
  battery.battery_remaining = -1;
  mavlink::common::BatteryStatus second = battery;
  second.id = 1;
  second.voltages[0] = 1000;
  mavlink::common::GpsRawInt gps{.fix_type = mavlink::common::GpsFixType::kNoFix,
                                 .lat = 473977420,
                                 .eph = 0xFFFF,
                                 .satellites_visible = 4};
  const base::RunTime now = base::steady_now();
  vehicle.say_heartbeat(now);
  vehicle.say(attitude, now);
  vehicle.say(no_battery, now);
  vehicle.say(battery, now);
  vehicle.say(second, now);
  vehicle.say(gps, now);
  vehicle.say_text("that is all", now);
  json telemetry;
  EXPECT_TRUE(cas::test::wait_until([&] {
    telemetry = call("vehicle.telemetry");
    return !telemetry.at("gps").at("age_s").is_null();
  }));
  EXPECT_EQ(telemetry.at("vehicle"), 1);
  EXPECT_NEAR(telemetry.at("attitude").at("roll_deg").get<double>(), 5.73, 0.01);
  EXPECT_TRUE(telemetry.at("attitude").at("yaw_deg").is_null());
  EXPECT_EQ(telemetry.at("battery").at("voltage_v"), 8.1);
  EXPECT_EQ(telemetry.at("battery").at("current_a"), 1.5);
  EXPECT_TRUE(telemetry.at("battery").at("remaining_percent").is_null());
  EXPECT_EQ(telemetry.at("gps").at("fix"), "no_fix");
  EXPECT_EQ(telemetry.at("gps").at("satellites"), 4);
  EXPECT_TRUE(telemetry.at("gps").at("lat_deg").is_null());
  EXPECT_TRUE(telemetry.at("gps").at("hdop").is_null());
  EXPECT_TRUE(telemetry.at("estimator").at("attitude_ok").is_null());
  EXPECT_TRUE(telemetry.at("position").at("age_s").is_null());
}

TEST_F(VehicleMethodsTest, PublishesStatusTextsToSubscribers) {
  fixture_.vehicle().script.result = MavResult::kFailed;
  fixture_.vehicle().script.text = "no way";
  call("subscribe", {{"topic", "statustext"}});
  error("vehicle.land");
  std::string method;
  json params;
  ASSERT_TRUE(client_->next_notification(method, params, std::chrono::seconds(5)));
  EXPECT_EQ(method, "statustext");
  EXPECT_EQ(params, (json{{"vehicle", 1}, {"severity", "critical"}, {"text", "no way"}}));
}

TEST_F(VehicleMethodsTest, AuditsWhoChangesAVehicleAndWhatCameOfIt) {
  fixture_.vehicle().params = {{"MIS_TAKEOFF_ALT", {.value = 10}}};
  call("vehicle.state");
  call("vehicle.takeoff", {{"altitude_m", 2.5}, {"vehicle", 1}});
  error("vehicle.mode", {{"mode", "WARP"}});
  fixture_.stop();
  ASSERT_EQ(fixture_.audit().size(), 2U);
  EXPECT_EQ(fixture_.audit()[0].rfind("127.0.0.1:", 0), 0U);
  EXPECT_THAT(fixture_.audit()[0],
              HasSubstr(R"( vehicle.takeoff {"altitude_m":2.5,"vehicle":1} vehicle 1: accepted)"));
  EXPECT_THAT(fixture_.audit()[1], HasSubstr("'WARP' is no mode of PX4"));
}

TEST_F(VehicleMethodsTest, KeepsTheAuditedCallsInItsJournal) {
  call("vehicle.state");
  call("vehicle.land", {{"vehicle", 1}});
  error("vehicle.mode", {{"mode", "WARP"}});
  error("vehicle.mode", {{"mode", "WARP"}});
  const json journal = call("casd.journal");
  EXPECT_EQ(journal.at("forgotten"), 0);
  const json& calls = journal.at("calls");
  ASSERT_EQ(calls.size(), 2U) << calls;
  EXPECT_EQ(calls[0].at("method"), "vehicle.land");
  EXPECT_EQ(calls[0].at("params"), (json{{"vehicle", 1}}));
  EXPECT_EQ(calls[0].at("vehicle"), 1);
  EXPECT_EQ(calls[0].at("client").get<std::string>().rfind("127.0.0.1:", 0), 0U);
  EXPECT_FALSE(calls[0].contains("refusal"));
  EXPECT_FALSE(calls[0].contains("times"));
  EXPECT_EQ(calls[1].at("times"), 2);
  EXPECT_THAT(calls[1].at("refusal").get<std::string>(), HasSubstr("WARP"));
  EXPECT_EQ(error("casd.journal", {{"since", 1}}).code(), -32602);
}

TEST(CallJournal, KeepsTheBeginningOfALongRefusal) {
  CallJournal journal;
  journal.add({.refusal = std::string(60'000, '\x01')});
  EXPECT_EQ(journal.answer().at("calls")[0].at("refusal").get<std::string>(),
            std::string(CallJournal::kMostRefusalBytes, '\x01'));
}

TEST(CallJournal, ForgetsTheOldestAndLongParameters) {
  CallJournal journal;
  for (std::size_t i = 0; i < CallJournal::kMost + 3; ++i) {
    journal.add(
        {.method = std::to_string(i),
         .params = i % 2 == 0 ? "{}" : std::string(CallJournal::kMostParamsBytes + 1, 'x')});
  }
  const json answer = journal.answer();
  EXPECT_EQ(answer.at("forgotten"), 3);
  ASSERT_EQ(answer.at("calls").size(), CallJournal::kMost);
  EXPECT_EQ(answer.at("calls")[0].at("method"), "3");
  EXPECT_TRUE(answer.at("calls")[0].at("params").is_null());
  EXPECT_EQ(answer.at("calls")[1].at("params"), json::object());
}

TEST_F(VehicleMethodsTest, AuditsARefusalThatRepeatsItselfOnce) {
  for (int i = 0; i < 10; ++i) error("vehicle.mode", {{"mode", "WARP"}});
  error("vehicle.mode", {{"mode", "WOOF"}});
  fixture_.stop();
  ASSERT_EQ(fixture_.audit().size(), 3U);
  EXPECT_THAT(fixture_.audit()[0], HasSubstr("WARP"));
  EXPECT_EQ(fixture_.audit()[1], "(the same again 9 times)");
  EXPECT_THAT(fixture_.audit()[2], HasSubstr("WOOF"));
}

}  // namespace
}  // namespace cas::casd
