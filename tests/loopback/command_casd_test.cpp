// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "tests/loopback/running_casd.hpp"
#include "tests/loopback/scripted_vehicle.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

using casd::test::FakeVehicle;
using mavlink::common::MavCmd;
using mavlink::common::MavModeFlag;
using mavlink::common::MavParamType;
using mavlink::common::MavResult;
using nlohmann::json;
using testing::HasSubstr;

/// The real casd between a scripted vehicle on a line and clients of its command port.
class CommandCasdTest : public testing::Test {
 protected:
  CommandCasdTest() : line_(folder_ / "fcu0") {}

  /// Starts vehicle and daemon, and waits until casd knows the vehicle.
  void start(std::function<void(FakeVehicle&)> script, const std::string& more = "") {
    vehicle_ = std::make_unique<ScriptedVehicle>(line_, std::move(script));
    topology_ = folder_.write("casd.yaml",
                              "schema: 1\n"
                              "command_port: {port: 0, loopback_without_token: true}\n"
                              "links:\n"
                              "  - {name: fcu, type: serial, baud: 921600, device: '" +
                                  (folder_ / "fcu0").string() + "'}\n" + "gains: " +
                                  cas::test::source_dir() + "/config/gains.yaml\n" + more);
    run_casd();
  }
  void run_casd() {
    casd_ = std::make_unique<RunningCasd>(std::vector<std::string>{
        kCasdProgram, topology_.string(), "--stats", (folder_ / "stats").string()});
    ASSERT_TRUE(wait_until([this] { return !casd_->call("casd.status").at("vehicles").empty(); }))
        << casd_->output();
  }
  Ended casctl(const std::vector<std::string>& arguments) const { return casd_->casctl(arguments); }

  TemporaryFolder folder_;
  PtyPair line_;
  std::unique_ptr<ScriptedVehicle> vehicle_;
  std::unique_ptr<RunningCasd> casd_;
  std::filesystem::path topology_;
};

void know_gains(FakeVehicle& vehicle) {
  vehicle.params = {{"MC_ROLLRATE_P", {.value = 0.15}},
                    {"MC_ROLLRATE_I", {.value = 0.2}},
                    {"MC_ROLLRATE_D", {.value = 0.003}},
                    {"MC_ROLL_P", {.value = 6.5}},
                    {"SYS_HITL", {.value = 1, .type = MavParamType::kInt32}}};
}

TEST_F(CommandCasdTest, ArmsTakesOffAndLandsThroughALine) {
  start([](FakeVehicle& vehicle) {
    mavlink::common::HomePosition home{.altitude = 488'000};
    // Again and again: on a busy machine casd may not listen yet.
    for (int i = 0; i < 20; ++i) {
      vehicle.say(home, base::steady_now() + std::chrono::milliseconds(300 + 500 * i));
    }
  });
  EXPECT_TRUE(wait_until([this] { return casd_->call("vehicle.state").contains("home"); }));
  EXPECT_THAT(casctl({"arm", "--no-wait"}), EndedWith(0));
  EXPECT_THAT(casctl({"takeoff", "2.5"}), EndedWith(0));
  EXPECT_THAT(casctl({"land"}), EndedWith(0));
  const auto& commands = vehicle_->stop().commands;
  bool climbed = false;
  for (const auto& command : commands) {
    if (command.command == mavlink::common::MavCmd::kNavTakeoff) {
      climbed = command.param7 == 490.5F;
    }
  }
  EXPECT_TRUE(climbed);
}

TEST_F(CommandCasdTest, GivesTheVehiclesReasonForARefusal) {
  start([](FakeVehicle& vehicle) {
    vehicle.script.result = MavResult::kTemporarilyRejected;
    vehicle.script.text = "Arming denied: high gyro bias";
  });
  EXPECT_THAT(casctl({"arm", "--no-wait"}), EndedWith(1, "Arming denied: high gyro bias"));
}

TEST_F(CommandCasdTest, HoldsTheInterlock) {
  start([](FakeVehicle& vehicle) { vehicle.base_mode = MavModeFlag::kCustomModeEnabled; });
  EXPECT_THAT(casctl({"arm", "--not-hil"}),
              EndedWith(1, testing::Not(testing::HasSubstr("waiting")), "allow_not_hil"));
  for (const auto& command : vehicle_->stop().commands) {
    EXPECT_NE(command.command, mavlink::common::MavCmd::kComponentArmDisarm);
  }
}

TEST_F(CommandCasdTest, ReportsAVehicleThatNeverAnswers) {
  start([](FakeVehicle& vehicle) { vehicle.script.answers = 0; });
  EXPECT_THAT(casctl({"land"}), EndedWith(4));
}

struct OldNewsCase {
  const char* name;
  MavCmd command;  ///< the vehicle acknowledges it and says nothing more
  std::vector<std::string> verb;
  bool armed;
};

/// A vehicle whose packets from before the command already show the wanted state.
class OldNews : public CommandCasdTest, public testing::WithParamInterface<OldNewsCase> {
 protected:
  static void say_all(FakeVehicle& vehicle, base::RunTime now) {
    mavlink::common::LocalPositionNed place{.z = -2.5F};
    mavlink::common::ExtendedSysState landed;
    landed.landed_state = mavlink::common::MavLandedState::kOnGround;
    for (int i = 0; i < 300; ++i) {
      const base::RunTime at = now + i * std::chrono::milliseconds(100);
      vehicle.say(mavlink::common::HomePosition{}, at);
      vehicle.say(place, at);
      vehicle.say(landed, at);
    }
  }

  void start_with(std::optional<MavCmd> silent_from) {
    start([silent_from, armed = GetParam().armed](FakeVehicle& vehicle) {
      vehicle.script.silent_from = silent_from;
      if (armed) vehicle.base_mode |= MavModeFlag::kSafetyArmed;
      say_all(vehicle, base::steady_now());
    });
    ASSERT_TRUE(wait_until([this] {
      const json state = casd_->call("vehicle.state");
      return state.contains("altitude_m") && state.contains("landed_age_s");
    })) << "what was heard before the command";
  }

  std::vector<std::string> waiting(const char* timeout_s) const {
    std::vector<std::string> call = GetParam().verb;
    call.insert(call.end(), {"--wait", "--timeout", timeout_s});
    return call;
  }
};

TEST_P(OldNews, IsNotTakenForTheStateThatACommandReached) {
  start_with(GetParam().command);
  const Ended said = casctl(waiting("2"));
  EXPECT_EQ(said.code, 4) << said.output;  // also for the acknowledgement
  EXPECT_THAT(said.output, HasSubstr("acknowledged, but the vehicle was not heard to be"));
  const bool is_about_arming = GetParam().command == MavCmd::kComponentArmDisarm;
  EXPECT_TRUE(!is_about_arming || said.output.find("arm it with") == std::string::npos)
      << said.output;
}

TEST_P(OldNews, IsFollowedByNewOfAVehicleThatGoesOnTalking) {
  start_with(std::nullopt);
  EXPECT_THAT(casctl(waiting("20")), EndedWith(0));
}

INSTANTIATE_TEST_SUITE_P(
    Verbs, OldNews,
    testing::Values(OldNewsCase{"Arm", MavCmd::kComponentArmDisarm, {"arm", "--no-wait"}, true},
                    OldNewsCase{"Disarm", MavCmd::kComponentArmDisarm, {"disarm"}, false},
                    OldNewsCase{"Takeoff", MavCmd::kNavTakeoff, {"takeoff", "2.5"}, true},
                    OldNewsCase{"Land", MavCmd::kNavLand, {"land"}, true},
                    OldNewsCase{"Rtl", MavCmd::kNavReturnToLaunch, {"rtl"}, true},
                    OldNewsCase{"Goto", MavCmd::kDoReposition, {"goto", "0", "0", "-2.5"}, true}),
    [](const auto& test) { return test.param.name; });

TEST_F(CommandCasdTest, SaysForHowLongAVehicleHasBeenSilent) {
  start([](FakeVehicle& vehicle) { vehicle.script.silent_from = MavCmd::kComponentArmDisarm; });
  EXPECT_THAT(casctl({"arm", "--no-wait", "--wait", "--timeout", "4"}),
              EndedWith(4, "; no HEARTBEAT has come for "));
}

TEST_F(CommandCasdTest, StatusMarksASilentVehicle) {
  start([](FakeVehicle& vehicle) { vehicle.script.silent_from = MavCmd::kComponentArmDisarm; });
  EXPECT_THAT(casctl({"arm", "--no-wait"}), EndedWith(0));
  EXPECT_TRUE(wait_until(
      [this] { return casctl({"status"}).output.find(" ago (SILENT)") != std::string::npos; }));
}

TEST_F(CommandCasdTest, SetsAGainOnTheVehicle) {
  start(know_gains);
  EXPECT_THAT(casctl({"setgain", "rollrate", "0.16", "0.21", "0.004"}), EndedWith(0));
  EXPECT_FLOAT_EQ(static_cast<float>(vehicle_->stop().params["MC_ROLLRATE_D"].value), 0.004F);
}

TEST_F(CommandCasdTest, EndsWithFiguresAndAllConnectionsClosed) {
  start(know_gains);
  casd_->signal(SIGTERM);
  EXPECT_EQ(casd_->wait_exit(), 0);
  std::ifstream in(folder_ / "stats");
  const json stats = json::parse(in);
  EXPECT_EQ(stats.at("program"), "casd");
  EXPECT_GT(stats.at("links").at(0).at("rx").at("packets"), 0);
}

TEST_F(CommandCasdTest, ComesBackAfterAKillWithNothingStale) {
  start(know_gains);
  casd_->signal(SIGKILL);
  EXPECT_TRUE(casd_->wait_exit().has_value());
  EXPECT_THAT(casctl({"status"}), EndedWith(3));
  run_casd();
  EXPECT_THAT(casctl({"arm", "--no-wait"}), EndedWith(0));
  EXPECT_THAT(casctl({"param", "get", "SYS_HITL"}), EndedWith(0));
}

TEST_F(CommandCasdTest, SaysWhyALinkIsDown) {
  const auto topology = folder_.write("down.yaml",
                                      "schema: 1\n"
                                      "command_port: {port: 0, loopback_without_token: true}\n"
                                      "links:\n"
                                      "  - {name: fcu, type: serial, device: '" +
                                          (folder_ / "nowhere").string() + "'}\n");
  casd_ = std::make_unique<RunningCasd>(std::vector<std::string>{kCasdProgram, topology.string()});
  const json link = casd_->link("fcu");
  EXPECT_EQ(link.at("state"), "down");
  EXPECT_THAT(link.at("endpoint").get<std::string>(), HasSubstr("No such file")) << link;
  const Ended said = casctl({"status"});
  EXPECT_EQ(said.code, 0) << said.output;
  const std::size_t row = said.output.find("\nfcu ");
  ASSERT_NE(row, std::string::npos) << said.output;
  EXPECT_GT(said.output.find("/nowhere"), said.output.find('\n', row + 1))
      << "a column would be as wide\n"
      << said.output;
  EXPECT_THAT(said.output, HasSubstr("\nlink fcu is down: "));
}

TEST_F(CommandCasdTest, WritesWhoAskedWhatIntoItsLog) {
  start(know_gains);
  EXPECT_THAT(casctl({"disarm"}), EndedWith(0));
  EXPECT_TRUE(casd_->prints("vehicle.disarm {\"force\":false} vehicle 1: accepted"))
      << casd_->output();
}

TEST_F(CommandCasdTest, ShowsTheNewestValueOfAMessage) {
  start(know_gains);
  const json asked{{"link", "fcu"}, {"message", "HEARTBEAT"}, {"system", 1}, {"component", 1}};
  json value;
  EXPECT_TRUE(wait_until([&] {
    value = casd_->call("message.value", asked);
    return !value.at("fields").is_null();
  }));
  EXPECT_EQ(value.at("fields").at(1), (json{{"name", "autopilot"}, {"value", 12}}));
}

TEST_F(CommandCasdTest, IsDrivenFromItsPageByPythonAlone) {
  start(
      [](FakeVehicle& vehicle) {
        know_gains(vehicle);
        // Again and again: on a busy machine casd may not listen yet.
        for (int i = 0; i < 20; ++i) {
          const base::RunTime at = base::steady_now() + std::chrono::milliseconds(300 + 500 * i);
          vehicle.say(mavlink::common::HomePosition{}, at);
          vehicle.say(mavlink::common::Attitude{}, at);
          vehicle.say(mavlink::common::LocalPositionNed{}, at);
          vehicle.say(mavlink::common::GlobalPositionInt{}, at);
          vehicle.say_text("Ready for takeoff!", at);
        }
      },
      "log: {folder: '" + folder_.path().string() + "'}\n");
  EXPECT_TRUE(
      wait_until([this] { return !casd_->call("vehicle.state").at("statustexts").empty(); }));
  ChildProcess python({"/usr/bin/env", "python3",
                       cas::test::source_dir() + "/tests/loopback/protocol_client.py",
                       cas::test::source_dir() + "/docs/develop/protocol.md", casd_->address()});
  EXPECT_EQ(python.wait_exit(std::chrono::seconds(60)), 0) << python.output();
}

}  // namespace
}  // namespace cas::test
