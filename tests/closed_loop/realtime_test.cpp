// SPDX-License-Identifier: BSD-3-Clause
// A flight through the three programs in real time: wants a quiet machine.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/vehicle_summary.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::hils {
namespace {

using test::ChildProcess;

constexpr const char* kGone =
    "sensors: rtk\nplugins: [{plugin: fault, faults: [{name: gone, when: phase == hold, for_s: "
    "0.5, drop: gps}]}]\n";
const std::string kScenario = cas::test::scenario_text(
    cas::test::paper_quadrotor() + kGone,
    "[arm, takeoff: {altitude_m: 2}, hold: {duration_s: 3, measure: true}, land: {timeout_s: 60}]");

const std::string kIris = cas::test::source_dir() + "/config/vehicles/iris_paper.yaml";
const std::string kTwoVehicles = cas::test::scenario_text(
    "vehicles:\n  - {name: left, vehicle: " + kIris + ", pose: {x_m: 0, y_m: 0}}\n" +
        "  - {name: right, vehicle: " + kIris + ", pose: {x_m: 3, y_m: 0}}\n" + R"(sensors: rtk
line: {preset: baud_921600}
ground_station: true
faults:
  - {name: line cut, vehicle: left, when: phase == cut, for_s: 0.1, line: {packet_loss: 1}}
)",
    "[arm, takeoff: {altitude_m: 2}, goto: {vehicle: right, north_m: 1, east_m: 0, up_m: 2}, "
    "hold: {name: cut, duration_s: 3, measure: true}, land: {timeout_s: 60}]");

TEST(RealTime, TheFlightTellsTheSimulatorItsPhase) {
  const test::TemporaryFolder folder;
  const std::filesystem::path scenario = folder.write("short.yaml", kScenario);
  const std::filesystem::path out = folder / "out";
  ChildProcess hils(
      {cas::test::binary_dir() + "/bin/hils", "run", scenario.string(), "--out", out.string()});
  EXPECT_EQ(hils.wait_exit(std::chrono::seconds(120)), 0) << hils.output();
  const auto stats = nlohmann::json::parse(std::ifstream(out / "run" / "hilsim_stats.json"));
  const auto& events = stats.at("plugins").at("fault@iris0").at("events");
  ASSERT_EQ(events.size(), 2U) << stats.dump();
  EXPECT_EQ(events[0].at("fault"), "gone");
  EXPECT_NEAR(events[1].at("time_s").get<double>() - events[0].at("time_s").get<double>(), 0.5,
              1e-3);
}

/// The emulator's terminal in place of a board's port; the emulator is not started by hils.
TEST(RealTime, FliesAControllerThatIsThereAlready) {
  const test::TemporaryFolder folder;
  const std::filesystem::path scenario = folder.write("short.yaml", kScenario);
  const std::filesystem::path out = folder / "out";
  const std::filesystem::path port = folder / "board";
  ChildProcess board({cas::test::binary_dir() + "/bin/fcu_emulator",
                      cas::test::source_dir() + "/config/fcu/iris_paper.yaml", "--link",
                      port.string()});
  ASSERT_TRUE(test::wait_until([&] { return std::filesystem::exists(port); }));
  ChildProcess hils({cas::test::binary_dir() + "/bin/hils", "run", scenario.string(), "--fcu",
                     port.string(), "--out", out.string()});
  EXPECT_EQ(hils.wait_exit(std::chrono::seconds(120)), 0) << hils.output();
  const nlohmann::json summary = test::vehicle_summary(out);
  EXPECT_TRUE(summary.at("from_device"));
  EXPECT_EQ(summary.at("rates").at("HIL_SENSOR").at("lost"), 0);
}

TEST(RealTime, RefusesAPortWithNobodyBehindIt) {
  const test::TemporaryFolder folder;
  const std::filesystem::path scenario = folder.write("short.yaml", kScenario);
  ChildProcess hils({cas::test::binary_dir() + "/bin/hils", "run", scenario.string(), "--fcu",
                     (folder / "nothing").string(), "--out", (folder / "out").string()});
  EXPECT_EQ(hils.wait_exit(std::chrono::seconds(60)), 3) << hils.output();
  EXPECT_NE(hils.output().find("cannot be opened"), std::string::npos) << hils.output();
}

/// Two emulators on two terminals, one simulator, one casd; the line of one is cut for a moment.
TEST(RealTime, TwoVehiclesFlyThroughOneCasd) {
  const test::TemporaryFolder folder;
  const std::filesystem::path scenario = folder.write("two.yaml", kTwoVehicles);
  const std::filesystem::path out = folder / "out";
  ChildProcess hils(
      {cas::test::binary_dir() + "/bin/hils", "run", scenario.string(), "--out", out.string()});
  EXPECT_EQ(hils.wait_exit(std::chrono::seconds(150)), 0) << hils.output();
  const auto summary = nlohmann::json::parse(std::ifstream(out / "summary.json"));
  const auto& vehicles = summary.at("vehicles");
  ASSERT_EQ(vehicles.size(), 2U);
  const auto lost = [&](std::size_t vehicle, const char* message) {
    return vehicles[vehicle].at("rates").at(message).at("lost").get<int>();
  };
  EXPECT_GT(lost(0, "HIL_SENSOR"), 0) << hils.output();
  for (const char* message : {"HIL_SENSOR", "HIL_GPS", "HIL_CONTROLS"}) {
    EXPECT_EQ(lost(1, message), 0) << message << hils.output();
  }
  EXPECT_EQ(vehicles[0].at("faults").size(), 1U);
  EXPECT_TRUE(vehicles[1].at("faults").empty());
  for (const char* file : {"truth_left.csv", "truth_right.csv", "flight.tlog", "report.html"}) {
    EXPECT_TRUE(std::filesystem::exists(out / file)) << file;
  }
}

}  // namespace
}  // namespace cas::hils
