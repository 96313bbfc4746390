// SPDX-License-Identifier: BSD-3-Clause
// A flight through the three programs in real time: wants a quiet machine.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/child_process.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::hils {
namespace {

using test::ChildProcess;

constexpr const char* kScenario = R"(schema: 1
vehicle: )" CAS_SOURCE_DIR R"(/config/vehicles/iris_paper.yaml
home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}
rates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}
line: {preset: baud_921600}
sensors: rtk
plugins:
  - {plugin: fault, faults: [{name: gone, when: phase == hold, for_s: 0.5, drop: gps}]}
steps:
  - arm
  - takeoff: {altitude_m: 2}
  - hold: {duration_s: 3, measure: true}
  - land: {timeout_s: 60}
)";

TEST(RealTime, TheFlightTellsTheSimulatorItsPhase) {
  const test::TemporaryFolder folder;
  const std::filesystem::path scenario = folder.write("short.yaml", kScenario);
  const std::filesystem::path out = folder / "out";
  ChildProcess hils({CAS_BINARY_DIR "/bin/hils", "run", scenario.string(), "--out", out.string()});
  EXPECT_EQ(hils.wait_exit(std::chrono::seconds(120)), 0) << hils.output();
  const auto stats = nlohmann::json::parse(std::ifstream(out / "run" / "hilsim_stats.json"));
  const auto& events = stats.at("plugins").at("fault@iris0").at("events");
  ASSERT_EQ(events.size(), 2U) << stats.dump();
  EXPECT_EQ(events[0].at("fault"), "gone");
  EXPECT_NEAR(events[1].at("time_s").get<double>() - events[0].at("time_s").get<double>(), 0.5,
              1e-3);
}

/// The emulator's terminal in the place of a board's port, started as somebody else's program.
TEST(RealTime, FliesAControllerThatIsThereAlready) {
  const test::TemporaryFolder folder;
  const std::filesystem::path scenario = folder.write("short.yaml", kScenario);
  const std::filesystem::path out = folder / "out";
  const std::filesystem::path port = folder / "board";
  ChildProcess board({CAS_BINARY_DIR "/bin/fcu_emulator",
                      CAS_SOURCE_DIR "/config/fcu/iris_paper.yaml", "--link", port.string()});
  ASSERT_TRUE(test::wait_until([&] { return std::filesystem::exists(port); }));
  ChildProcess hils({CAS_BINARY_DIR "/bin/hils", "run", scenario.string(), "--fcu", port.string(),
                     "--out", out.string()});
  EXPECT_EQ(hils.wait_exit(std::chrono::seconds(120)), 0) << hils.output();
  const auto summary = nlohmann::json::parse(std::ifstream(out / "summary.json"));
  EXPECT_TRUE(summary.at("from_device"));
  EXPECT_EQ(summary.at("rates").at("HIL_SENSOR").at("lost"), 0);
}

TEST(RealTime, RefusesAPortWithNobodyBehindIt) {
  const test::TemporaryFolder folder;
  const std::filesystem::path scenario = folder.write("short.yaml", kScenario);
  ChildProcess hils({CAS_BINARY_DIR "/bin/hils", "run", scenario.string(), "--fcu",
                     (folder / "nothing").string(), "--out", (folder / "out").string()});
  EXPECT_EQ(hils.wait_exit(std::chrono::seconds(60)), 3) << hils.output();
  EXPECT_NE(hils.output().find("cannot be opened"), std::string::npos) << hils.output();
}

}  // namespace
}  // namespace cas::hils
