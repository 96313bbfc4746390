// SPDX-License-Identifier: BSD-3-Clause
// A plugin's declared messages reach the controller, and its figures are in the results.
#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "tests/support/battery_vehicle.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/vehicle_summary.hpp"

namespace cas::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

constexpr int kExitUsage = 2;
constexpr base::Duration kFlight = std::chrono::seconds(180);  // in lockstep, on a busy machine

/// A short flight with further plugins.
class PluginOutput : public testing::Test {
 protected:
  /// Flies, or is refused. @param plugins  as in a scenario
  void run(const std::string& plugins, const std::vector<std::string>& flags, int exit_code) {
    const std::string scenario =
        folder_
            .write(
                "own.yaml",
                scenario_text("vehicle: " + vehicle_ +
                                  "\nline: {preset: baud_921600}\narchitecture: tcas\nplugins:\n" +
                                  plugins + "\n",
                              "[arm, takeoff: {altitude_m: 2}, hold: {duration_s: 1, measure: "
                              "true}, land, disarm]"))
            .string();
    std::vector<std::string> command{binary_dir() + "/bin/hils",
                                     "run",
                                     scenario,
                                     "--out",
                                     out().string(),
                                     "--plugin-dir",
                                     binary_dir() + "/tests/fake_plugins"};
    command.insert(command.end(), flags.begin(), flags.end());
    ChildProcess hils(command);
    EXPECT_EQ(hils.wait_exit(kFlight), exit_code) << hils.output();
    output_ = hils.output();
  }

  std::filesystem::path out() const { return folder_ / "out"; }
  std::string text(const std::string& file) const { return TemporaryFolder::read(out() / file); }
  json figures(const std::string& file) const { return json::parse(text(file)); }

  /// Messages that the route from simulator to controller allows.
  std::vector<std::string> allowed() const {
    const auto casd = base::ConfigNode::load(out() / "run" / "casd.yaml");
    std::vector<std::string> names;
    const auto route = casd.at("routes").items().at(0);
    for (const auto& name : route.at("allow").items()) names.push_back(name.as<std::string>());
    return names;
  }

  TemporaryFolder folder_;
  std::string vehicle_ = source_dir() + "/config/vehicles/iris_paper.yaml";
  std::string output_;
};

TEST_F(PluginOutput, PassesTheRoutesOfARunWhenItIsDeclared) {
  run("  - {plugin: rangefinder, rate_hz: 20, stddev_m: 0.01, min_m: 0.1, max_m: 40}\n"
      "  - {plugin: fake_sender}\n",
      {"--lockstep"}, 0);
  EXPECT_EQ(allowed(),
            (std::vector<std::string>{"HEARTBEAT", "HIL_SENSOR", "HIL_GPS", "DISTANCE_SENSOR",
                                      "BATTERY_STATUS", "HIL_OPTICAL_FLOW", "OPTICAL_FLOW"}));

  const json sent = figures("run/hilsim_stats.json").at("plugins").at("mavlink_interface@iris0");
  const json received = figures("run/fcu_emulator_stats.json").at("received");
  EXPECT_GT(sent.at("sent").at("BATTERY_STATUS"), 30);
  for (const char* message : {"DISTANCE_SENSOR", "BATTERY_STATUS", "HIL_OPTICAL_FLOW"}) {
    const int count = sent.at("sent").at(message);
    EXPECT_NEAR(received.value(message, 0), count, 2) << message;  // in flight at the end
  }
  EXPECT_FALSE(sent.at("sent").contains("STATUSTEXT"));
  EXPECT_FALSE(received.contains("STATUSTEXT"));

  const json refused = sent.at("plugins").at("fake_sender");
  EXPECT_EQ(refused.at("declares"), json({"BATTERY_STATUS", "HIL_OPTICAL_FLOW", "OPTICAL_FLOW"}));
  EXPECT_EQ(refused.at("undeclared"), sent.at("sent").at("BATTERY_STATUS"));
  EXPECT_EQ(refused.at("wrong_size"), sent.at("sent").at("BATTERY_STATUS"));
  EXPECT_THAT(text("run/hilsim.log"),
              HasSubstr("plugin fake_sender publishes STATUSTEXT, which it does not declare"));
}

TEST_F(PluginOutput, OdometryPassesTheRoutesOfARun) {
  run("  - {plugin: odometry, rate_hz: 30, position_stddev_m: 0.01, attitude_stddev_deg: 0.3, "
      "velocity_stddev_m_s: 0.05, rate_stddev_deg_s: 0.5}\n",
      {"--lockstep"}, 0);
  EXPECT_EQ(allowed(), (std::vector<std::string>{"HEARTBEAT", "HIL_SENSOR", "HIL_GPS", "ODOMETRY",
                                                 "VISION_POSITION_ESTIMATE"}));
  const json sent = figures("run/hilsim_stats.json").at("plugins").at("mavlink_interface@iris0");
  const int count = sent.at("sent").at("ODOMETRY");
  EXPECT_GT(count, 100);
  EXPECT_FALSE(sent.at("sent").contains("VISION_POSITION_ESTIMATE"));
  const json received = figures("run/fcu_emulator_stats.json").at("received");
  EXPECT_NEAR(received.value("ODOMETRY", 0), count, 2);  // in flight at the end
}

TEST_F(PluginOutput, LeavesTheRoutesAloneWhereNothingIsDeclared) {
  run("  - {plugin: fake_listener}\n", {"--virtual"}, 0);
  EXPECT_EQ(allowed(), (std::vector<std::string>{"HEARTBEAT", "HIL_SENSOR", "HIL_GPS"}));
  EXPECT_EQ(vehicle_summary(out()).at("plugins"), json::object());
  EXPECT_THAT(text("report.html"), Not(HasSubstr(">Plugins<")));
}

TEST_F(PluginOutput, ABatteryOfTheVehicleFilePassesTheRoutesOfARun) {
  vehicle_ = write_with_battery(
      folder_, "{full_v: 16, empty_v: 14, capacity_ah: 5, resistance_ohm: 0.005, efficiency: 0.9}");
  run("  - {plugin: fake_listener}\n", {"--virtual"}, 0);
  EXPECT_EQ(allowed(),
            (std::vector<std::string>{"HEARTBEAT", "HIL_SENSOR", "HIL_GPS", "BATTERY_STATUS"}));
  const json sent = figures("run/hilsim_stats.json").at("plugins").at("mavlink_interface@iris0");
  EXPECT_GT(sent.at("sent").at("BATTERY_STATUS"), 10);
}

TEST_F(PluginOutput, IsInSummaryAndReportUnderNamesThatAreText) {
  run("  - {plugin: fake_sender}\n", {"--virtual"}, 0);
  const json own = vehicle_summary(out()).at("plugins").at("fake_sender");
  const json sine = own.at("<script>alert(\"sine\")</script>");
  EXPECT_EQ(sine.at("unit"), "\"&<b>");
  EXPECT_GT(sine.at("samples"), 30);
  EXPECT_LE(sine.at("max"), 1.0);
  EXPECT_GE(sine.at("min"), -1.0);
  EXPECT_EQ(own.at("sum & <i>total</i>").at("value"), sine.at("samples"));
  EXPECT_TRUE(own.at("never").at("value").is_null());
  EXPECT_EQ(own.at("../../etc/passwd").at("not_finite"), sine.at("samples"));
  EXPECT_EQ(own.at("../../etc/passwd").at("unit"), "\xC2\xB5V");

  const std::string report = text("report.html");
  EXPECT_THAT(report, HasSubstr("<h2>Plugins</h2>"));
  EXPECT_THAT(report, HasSubstr("<td>sum &amp; &lt;i&gt;total&lt;/i&gt;</td>"));
  EXPECT_THAT(report, HasSubstr("fake_sender: &lt;script&gt;alert(&quot;sine&quot;)"));
  EXPECT_THAT(report, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(report, Not(HasSubstr("<i>total")));

  const std::filesystem::path plots = out() / "plots";
  EXPECT_TRUE(is_regular_file(plots / "plugin_fake_sender_______etc_passwd.svg"));
  EXPECT_THAT(text("plots/plugin_fake_sender_______etc_passwd.svg"), HasSubstr("../../etc/passwd"));
  EXPECT_THAT(output_, HasSubstr("fake_sender  sum & <i>total</i>"));
}

TEST_F(PluginOutput, ComesFromThisRunAlone) {
  run("  - {plugin: fake_sender}\n", {"--virtual"}, 0);
  EXPECT_TRUE(is_regular_file(out() / "plugin_figures.json"));
  run("  - {plugin: fake_listener}\n", {"--virtual"}, 0);
  EXPECT_FALSE(is_regular_file(out() / "plugin_figures.json"));
  EXPECT_EQ(vehicle_summary(out()).at("plugins"), json::object());
}

TEST_F(PluginOutput, IsRefusedWhereItMayNotBe) {
  run("  - {plugin: fake_undeclared}\n", {"--virtual"}, kExitUsage);
  EXPECT_THAT(output_,
              HasSubstr("plugin fake_undeclared@iris0: sends MAVLink messages and declares none"));
  run("  - {plugin: fake_second_imu}\n", {"--virtual"}, kExitUsage);
  EXPECT_THAT(output_, HasSubstr("own.yaml:"));
  EXPECT_THAT(output_, HasSubstr("plugin fake_second_imu declares HIL_SENSOR, which the loop"));
}

}  // namespace
}  // namespace cas::test
