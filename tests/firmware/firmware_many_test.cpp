// SPDX-License-Identifier: BSD-3-Clause
// Many flights of stock firmware: a sweep with several at once, a campaign, and a comparison with
// ours.
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/firmware/sitl_flight.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {
namespace {

class FirmwareMany : public SitlFlight {
 protected:
  /// Runs hils to its end. @return its exit code
  std::optional<int> hils(std::vector<std::string> words) {
    words.insert(words.begin(), binary_dir() + "/bin/hils");
    hils_.emplace(words);
    return hils_->wait_exit(3 * kFlightPatience);  // several flights, perhaps one after the other
  }
};

/// Whether this system gives a process a network of its own.
bool has_private_networks() {
  const int status = std::system("unshare -n true 2>/dev/null || unshare -rn true 2>/dev/null");
  return status == 0;
}

TEST_F(FirmwareMany, SweptFlySeveralAtOnceOnTheSamePorts) {
  if (!has_private_networks()) GTEST_SKIP() << "no network namespaces here";
  write_scenario("obedient");
  const auto study = folder_.write("study.yaml", R"(schema: 1
scenario: scenario.yaml
seeds: [3]
vary: [{name: height, key: "steps[takeoff].altitude_m", values: [2, 2.5, 3]}]
)");
  ASSERT_EQ(hils({"sweep", study.string(), "--jobs", "3", "--out", folder_ / "out"}), 0)
      << output();
  const std::string results = left("results.csv");
  std::size_t passed = 0;
  for (std::size_t at = results.find(",passed,"); at != results.npos;
       at = results.find(",passed,", at + 1)) {
    ++passed;
  }
  EXPECT_EQ(passed, 3U) << results;
}

/// Two failures strike in the hover: the vehicle withstands one, and does not survive the other.
TEST_F(FirmwareMany, AreStruckByACampaign) {
  if (!has_private_networks()) GTEST_SKIP() << "no network namespaces here";
  write_scenario("obedient", "", R"(  - takeoff: {altitude_m: 2, timeout_s: 200}
  - hold: {name: hover, duration_s: 4, measure: true}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
)");
  const auto campaign = folder_.write("campaign.yaml", R"(schema: 1
name: struck
scenario: scenario.yaml
phases: {hover: phase == hover}
failures:
  - {failure: battery_sag, expect: [stays_up, no_farther_than_m: 3]}
  - {failure: rotor_stopped, expect: [stays_up]}
)");
  EXPECT_EQ(hils({"campaign", campaign.string(), "--jobs", "2", "--replays", "1", "--out",
                  folder_ / "out"}),
            1)
      << output();
  EXPECT_TRUE(says("1 of 2 cells as expected, 1 missed, 0 without a verdict")) << output();
  const auto results = nlohmann::json::parse(left("results.json"));
  ASSERT_EQ(results.at("cells").size(), 2U);
  for (const auto& cell : results.at("cells")) {
    EXPECT_GT(cell.at("flights").at(0).at("strike_s").get<double>(), 1) << cell;
  }
  EXPECT_FALSE(left("again/row_2/report.html").empty()) << "the missed flight is there to look at";
}

/// The shipped ports of its simulation and topology are those of its private network.
TEST_F(FirmwareMany, FlyAVehicleThatTheScenarioNamesWithoutFurtherFiles) {
  if (!has_private_networks()) GTEST_SKIP() << "no network namespaces here";
  const std::string vehicle = source_dir() + "/config/vehicles/iris_px4.yaml";
  const auto scenario = folder_.write(
      "own.yaml", "schema: 1\nvehicle: " + vehicle + R"(
home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}
not_hil: true
firmware:
  autopilot: PX4
  command: [')" + binary_dir() +
                      R"(/tests/scripted_firmware', px4-sitl, '4560', '18570', '14550', obedient]
steps:
  - arm: {timeout_s: 100}
)" + kOneFlight + "limits: {height_error_m: 0.5}\n");
  ASSERT_EQ(hils({"run", scenario.string(), "--lockstep", "--out", folder_ / "out"}), 0)
      << output();
  EXPECT_LT(summary().at("height_error_m").get<double>(), 0.5);
}

TEST_F(FirmwareMany, AreComparedWithOurController) {
  const auto stock = write_scenario("obedient");
  const std::string ours = source_dir() + "/config/scenarios/step.yaml";
  ASSERT_EQ(hils({"compare", stock.string(), ours, "--virtual", "--seeds", "1", "--out",
                  folder_ / "out"}),
            0)
      << output();
  const auto comparison = nlohmann::json::parse(left("comparison.json"));
  ASSERT_EQ(comparison.at("variants").size(), 2U);
  for (const auto& variant : comparison.at("variants")) {
    EXPECT_FALSE(variant.at("figures").at("rms_z_m").is_null()) << variant.dump(2);
  }
  EXPECT_TRUE(comparison.at("variants").at(0).at("figures").at("sensor_lost").is_null())
      << "firmware in software has no stream of packets";
  EXPECT_TRUE(says("stock PX4")) << output();
}

TEST_F(FirmwareMany, LeaveWhatEveryRunLeaves) {
  write_scenario("obedient");
  folder_.write("web/index.html", "-");
  folder_.write("web/replay.html", "<body><!--RECORDS--></body>");
  hils_.emplace(
      std::vector<std::string>{"/usr/bin/env", "CAS_WEB_PATH=" + (folder_.path() / "web").string(),
                               binary_dir() + "/bin/hils", "run", folder_ / "scenario.yaml",
                               "--seed", "9", "--lockstep", "--out", folder_ / "out"});
  ASSERT_EQ(hils_->wait_exit(kFlightPatience), 0) << output();
  EXPECT_NE(left("replay.html").find("class=\"record\""), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(left("summary.json")).at("seed"), 9);
  for (const char* file : {"junit.xml", "report.html", "plots/track.svg", "flight.ulg",
                           "flight.tlog", "sensors/imu.csv"}) {
    EXPECT_FALSE(left(file).empty()) << file;
  }
}

}  // namespace
}  // namespace cas::test
