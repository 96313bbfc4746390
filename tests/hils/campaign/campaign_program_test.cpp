// SPDX-License-Identifier: BSD-3-Clause
// A campaign as a user starts it: three failures in two phases, one cell red on purpose.
#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

/// For a few flights, which take as long as the machine lets them.
constexpr base::Duration kCampaignPatience = std::chrono::minutes(8);

const std::string kScenario = scenario_text(paper_quadrotor(),
                                            "[arm, takeoff: {altitude_m: 1.5}, hold: {name: hover, "
                                            "duration_s: 4, measure: true}, land, disarm]");

/// A quadrotor with a stopped rotor cannot be flown: that cell is red on purpose.
constexpr const char* kCampaign = R"(
schema: 1
name: hops
scenario: hop.yaml
phases:
  rising: phase == takeoff and height > 0.8
  hover: phase == hover
failures:
  - {failure: baro_door, with: {pa: -2}, expect: [stays_up, no_farther_than_m: 1]}
  - {failure: imu_lost, expect: [terminates, detected_within_s: 1.5]}
  - {failure: rotor_stopped, expect: [crashes], expect_in: {hover: [stays_up]}}
)";

class CampaignProgram : public testing::Test {
 protected:
  CampaignProgram() {
    folder_.write("hop.yaml", kScenario);
    file_ = folder_.write("hops.yaml", kCampaign);
  }
  std::string hils(std::vector<std::string> words, int code) const {
    words.insert(words.begin(), {binary_dir() + "/bin/hils", "campaign"});
    ChildProcess program(std::move(words));
    EXPECT_EQ(program.wait_exit(kCampaignPatience), code) << program.output();
    return program.output();
  }
  static std::string read(const fs::path& file) { return TemporaryFolder::read(file); }

  TemporaryFolder folder_;
  fs::path file_;
};

TEST_F(CampaignProgram, FliesJudgesAndReportsEachCell) {
  const fs::path out = folder_ / "out";
  const std::string said = hils({file_.string(), "--out", out.string(), "--jobs", "2"}, 1);
  EXPECT_THAT(said, HasSubstr("5 of 6 cells as expected, 1 missed, 0 without a verdict"));
  EXPECT_TRUE(
      std::regex_search(said, std::regex("rotor_stopped +hover +missed .*  seed 1: stays up: ")))
      << said;

  const json results = json::parse(read(out / "results.json"));
  ASSERT_EQ(results["cells"].size(), 6U);
  for (const json& cell : results["cells"]) {
    const bool red = cell["failure"] == "rotor_stopped" && cell["phase"] == "hover";
    EXPECT_EQ(cell["verdict"], red ? "missed" : "as expected") << cell;
    EXPECT_GT(cell["flights"][0]["strike_s"].get<double>(), 1) << cell;
  }
  const json& lost = results["cells"][2];
  EXPECT_EQ(lost["failure"], "imu_lost");
  EXPECT_GT(lost["detected_s"].get<double>(), 0) << lost;
  EXPECT_TRUE(results["cells"][5]["flights"][0]["crashed"].get<bool>()) << results["cells"][5];

  const std::string junit = read(out / "junit.xml");
  EXPECT_THAT(junit, HasSubstr("tests=\"6\" failures=\"1\" errors=\"0\""));
  EXPECT_THAT(junit,
              HasSubstr("<testcase classname=\"hils.campaign.hops.rotor_stopped\" name=\"hover\" "
                        "time=\"0\"><failure"));
  EXPECT_THAT(read(out / "campaign.html"), HasSubstr("again/row_6/"));
  EXPECT_TRUE(fs::exists(out / "again/row_6/report.html"));
  EXPECT_TRUE(fs::exists(out / "results.csv"));

  // Expectations may change without a new flight.
  folder_.write("hops.yaml", std::string(kCampaign).replace(
                                 std::string(kCampaign).rfind("[stays_up]"), 10, "[crashes]"));
  const std::string again = hils({file_.string(), "--out", out.string(), "--replays", "0"}, 0);
  EXPECT_THAT(again, HasSubstr("6 of 6 cells as expected"));

  // A replay of another flight than the one that was judged is no proof.
  folder_.write("out/again/row_6/truth.csv", "another one");
  EXPECT_THAT(hils({file_.string(), "--out", out.string()}, 3),
              HasSubstr("row 6: another flight when it was flown again"));

  // Other failures are another campaign.
  folder_.write("hops.yaml",
                std::string(kCampaign) + "  - {failure: gps_lost, expect: [stays_up]}\n");
  EXPECT_THAT(hils({file_.string(), "--out", out.string()}, 2),
              HasSubstr("holds another campaign"));
}

TEST_F(CampaignProgram, WhatNeverActsIsNoPass) {
  folder_.write(
      "hops.yaml",
      "schema: 1\nname: hops\nscenario: hop.yaml\n"
      "phases: {hover: phase == hover, down: phase == done}\nfailures:\n"
      "  - {failure: rotor_weak, with: {share: 1}, phases: [hover], expect: [stays_up]}\n"
      "  - {failure: line_loss, with: {share: 0}, phases: [hover], expect: [stays_up]}\n"
      "  - {failure: ground_lost, with: {for_s: 0.5}, phases: [hover], expect: [stays_up]}\n"
      "  - {failure: gps_lost, phases: [down], expect: [stays_up]}\n");
  const std::string said =
      hils({file_.string(), "--out", (folder_ / "out").string(), "--replays", "0"}, 3);
  for (const char* cell : {"rotor_weak +hover +no verdict .* seed 1: never acted: to the byte",
                           "line_loss +hover +no verdict .* seed 1: never acted: to the byte",
                           "gps_lost +down +no verdict .* seed 1: never acted: it struck after"}) {
    EXPECT_TRUE(std::regex_search(said, std::regex(cell))) << said;
  }
  EXPECT_THAT(said, HasSubstr("1 of 4 cells as expected, 0 missed, 3 without a verdict"));
}

/// Flown by sticks, the vehicle returns by NAV_RCL_ACT once they are gone for COM_RC_LOSS_T.
TEST_F(CampaignProgram, TheLossOfTheRadioBringsTheVehicleHome) {
  std::string scenario = kScenario;
  scenario.replace(scenario.find("land"), 0,
                   "sticks: {pitch: 0.2, duration_s: 4}, hold: {duration_s: 1}, ");
  folder_.write("hop.yaml", scenario + "ground_station: true\n");
  folder_.write("hops.yaml",
                "schema: 1\nname: hops\nscenario: hop.yaml\n"
                "phases: {flown: phase == sticks and north > 0.5}\nfailures:\n"
                "  - {failure: rc_lost, expect: [no_crash, {failsafe: RTL, within_s: 2}]}\n"
                "  - {failure: imu_2_stuck, expect: [stays_up]}\n");
  const std::string said =
      hils({file_.string(), "--out", (folder_ / "out").string(), "--replays", "0"}, 0);
  EXPECT_THAT(said, HasSubstr("1 of 1 cells as expected"));
  EXPECT_THAT(said, HasSubstr("needs imu_2, which this vehicle does not have"));
}

TEST_F(CampaignProgram, ListsTheCatalogueAndRefusesHalfACommand) {
  EXPECT_THAT(hils({"--list"}, 0),
              HasSubstr("gps_spoofed (GPS): A spoofer leads the position away slowly"));
  EXPECT_THAT(hils({file_.string()}, 2), HasSubstr("--out DIR"));
  const std::string planned =
      hils({file_.string(), "--out", (folder_ / "plan").string(), "--plan"}, 0);
  EXPECT_THAT(planned, HasSubstr("3 failures, 7 flights (1 of them without a failure)"));
  EXPECT_TRUE(fs::exists(folder_ / "plan/table.csv"));
  folder_.write("hops.yaml", std::string(kCampaign).replace(std::string(kCampaign).find("hover:"),
                                                            6, "\"\\e[31m\":"));
  const std::string refused = hils({file_.string(), "--out", (folder_ / "p").string()}, 2);
  EXPECT_THAT(refused, HasSubstr("phases.?[31m: its name"));
  EXPECT_EQ(refused.find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace cas::test
