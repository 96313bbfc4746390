// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/rpc/client.hpp"
#include "tests/loopback/scripted_vehicle.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

using base::rpc::CallError;
using base::rpc::Client;
using casd::test::FakeVehicle;
using mavlink::common::MavCmd;
using mavlink::common::MavModeFlag;
using mavlink::common::MavParamType;
using mavlink::common::MavResult;
using nlohmann::json;

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
    casd_ = std::make_unique<ChildProcess>(
        std::vector<std::string>{cas::test::binary_dir() + "/bin/casd", topology_.string(),
                                 "--stats", (folder_ / "stats").string()});
    const std::optional<std::string> status = casd_->wait_ready();
    ASSERT_TRUE(status.has_value()) << casd_->output();
    address_ = word_after(*status, "command_port");
    client_.emplace(address_);
    ASSERT_TRUE(wait_until([this] {
      return !client_->call("casd.status", json::object()).at("vehicles").empty();
    })) << casd_->output();
  }
  /// Runs the real casctl. @return its exit code
  int casctl(std::vector<std::string> arguments, std::string* output = nullptr) {
    arguments.insert(arguments.begin(),
                     {cas::test::binary_dir() + "/bin/casctl", "--address", address_});
    ChildProcess child(arguments);
    const std::optional<int> code = child.wait_exit();
    if (output != nullptr) *output = child.output();
    return code.value_or(-1);
  }

  TemporaryFolder folder_;
  PtyPair line_;
  std::unique_ptr<ScriptedVehicle> vehicle_;
  std::unique_ptr<ChildProcess> casd_;
  std::filesystem::path topology_;
  std::string address_;
  std::optional<Client> client_;
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
    mavlink::common::HomePosition home;
    home.altitude = 488'000;
    // Again and again: on a busy machine casd may not listen yet.
    for (int i = 0; i < 20; ++i) {
      vehicle.say(home, base::steady_now() + std::chrono::milliseconds(300 + 500 * i));
    }
  });
  EXPECT_TRUE(wait_until(
      [this] { return client_->call("vehicle.state", json::object()).contains("home"); }));
  EXPECT_EQ(casctl({"arm", "--no-wait"}), 0);
  EXPECT_EQ(casctl({"takeoff", "2.5"}), 0);
  EXPECT_EQ(casctl({"land"}), 0);
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
  std::string output;
  EXPECT_EQ(casctl({"arm", "--no-wait"}, &output), 1);
  EXPECT_NE(output.find("Arming denied: high gyro bias"), std::string::npos) << output;
}

TEST_F(CommandCasdTest, HoldsTheInterlock) {
  start([](FakeVehicle& vehicle) { vehicle.base_mode = MavModeFlag::kCustomModeEnabled; });
  std::string output;
  EXPECT_EQ(casctl({"arm", "--not-hil"}, &output), 1);
  EXPECT_EQ(output.find("waiting"), std::string::npos) << output;
  EXPECT_NE(output.find("allow_not_hil"), std::string::npos) << output;
  for (const auto& command : vehicle_->stop().commands) {
    EXPECT_NE(command.command, mavlink::common::MavCmd::kComponentArmDisarm);
  }
}

TEST_F(CommandCasdTest, ReportsAVehicleThatNeverAnswers) {
  start([](FakeVehicle& vehicle) { vehicle.script.answers = 0; });
  EXPECT_EQ(casctl({"land"}), 4);
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
    mavlink::common::LocalPositionNed place;
    place.z = -2.5F;
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
      const json state = client_->call("vehicle.state", json::object());
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
  std::string said;
  EXPECT_EQ(casctl(waiting("2"), &said), 4) << said;  // also for the acknowledgement
  EXPECT_NE(said.find("acknowledged, but the vehicle was not heard to be"), std::string::npos)
      << said;
  const bool is_about_arming = GetParam().command == MavCmd::kComponentArmDisarm;
  EXPECT_TRUE(!is_about_arming || said.find("arm it with") == std::string::npos) << said;
}

TEST_P(OldNews, IsFollowedByNewOfAVehicleThatGoesOnTalking) {
  start_with(std::nullopt);
  std::string said;
  EXPECT_EQ(casctl(waiting("20"), &said), 0) << said;
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
  std::string said;
  EXPECT_EQ(casctl({"arm", "--no-wait", "--wait", "--timeout", "4"}, &said), 4) << said;
  EXPECT_NE(said.find("; no HEARTBEAT has come for "), std::string::npos) << said;
}

TEST_F(CommandCasdTest, StatusMarksASilentVehicle) {
  start([](FakeVehicle& vehicle) { vehicle.script.silent_from = MavCmd::kComponentArmDisarm; });
  EXPECT_EQ(casctl({"arm", "--no-wait"}), 0);
  EXPECT_TRUE(wait_until([this] {
    std::string said;
    casctl({"status"}, &said);
    return said.find(" ago (SILENT)") != std::string::npos;
  }));
}

TEST_F(CommandCasdTest, SetsAGainOnTheVehicle) {
  start(know_gains);
  EXPECT_EQ(casctl({"setgain", "rollrate", "0.16", "0.21", "0.004"}), 0);
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
  EXPECT_EQ(casctl({"status"}), 3);
  run_casd();
  EXPECT_EQ(casctl({"arm", "--no-wait"}), 0);
  EXPECT_EQ(casctl({"param", "get", "SYS_HITL"}), 0);
}

TEST_F(CommandCasdTest, SaysWhyALinkIsDown) {
  const auto topology = folder_.write("down.yaml",
                                      "schema: 1\n"
                                      "command_port: {port: 0, loopback_without_token: true}\n"
                                      "links:\n"
                                      "  - {name: fcu, type: serial, device: '" +
                                          (folder_ / "nowhere").string() + "'}\n");
  ChildProcess casd({cas::test::binary_dir() + "/bin/casd", topology.string()});
  const std::optional<std::string> status = casd.wait_ready();
  ASSERT_TRUE(status.has_value()) << casd.output();
  address_ = word_after(*status, "command_port");
  Client client(address_);
  const json link = client.call("link.list", json::object()).at(0);
  EXPECT_EQ(link.at("state"), "down");
  EXPECT_NE(link.at("endpoint").get<std::string>().find("No such file"), std::string::npos) << link;
  std::string said;
  EXPECT_EQ(casctl({"status"}, &said), 0);
  const std::size_t row = said.find("\nfcu ");
  ASSERT_NE(row, std::string::npos) << said;
  EXPECT_GT(said.find("/nowhere"), said.find('\n', row + 1)) << "a column would be as wide\n"
                                                             << said;
  EXPECT_NE(said.find("\nlink fcu is down: "), std::string::npos) << said;
}

TEST_F(CommandCasdTest, WritesWhoAskedWhatIntoItsLog) {
  start(know_gains);
  EXPECT_EQ(casctl({"disarm"}), 0);
  EXPECT_TRUE(wait_until([this] {
    return casd_->output().find("vehicle.disarm {\"force\":false} vehicle 1: accepted") !=
           std::string::npos;
  })) << casd_->output();
}

TEST_F(CommandCasdTest, ShowsTheNewestValueOfAMessage) {
  start(know_gains);
  const json asked{{"link", "fcu"}, {"message", "HEARTBEAT"}, {"system", 1}, {"component", 1}};
  json value;
  EXPECT_TRUE(wait_until([&] {
    value = client_->call("message.value", asked);
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
  EXPECT_TRUE(wait_until([this] {
    return !client_->call("vehicle.state", json::object()).at("statustexts").empty();
  }));
  ChildProcess python({"/usr/bin/env", "python3",
                       cas::test::source_dir() + "/tests/loopback/protocol_client.py",
                       cas::test::source_dir() + "/docs/develop/protocol.md", address_});
  EXPECT_EQ(python.wait_exit(std::chrono::seconds(60)), 0) << python.output();
}

}  // namespace
}  // namespace cas::test
