// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_scenario.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "hils/firmware/firmware_run.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

const std::filesystem::path kScenarios = cas::test::source_dir() + "/config/scenarios";

TEST(FirmwareScenario, TheShippedOnesAreRead) {
  for (const char* name : {"px4_sitl", "px4_hitl", "ardupilot"}) {
    const auto file = kScenarios / (std::string(name) + ".yaml");
    ASSERT_TRUE(FirmwareScenario::is(file)) << name;
    const FirmwareScenario scenario = FirmwareScenario::load(file);
    EXPECT_EQ(scenario.name, name);
    EXPECT_FALSE(scenario.firmware.command.empty());
    EXPECT_EQ(scenario.not_hil, !scenario.firmware.on_serial_line)
        << "only firmware without a wire is armed without the HIL flag";
  }
  EXPECT_FALSE(FirmwareScenario::is(kScenarios / "hover.yaml"));
}

TEST(FirmwareScenario, FindsTheShippedWorldAndTopologyFromAFolderOfOnesOwn) {
  const test::TemporaryFolder folder;
  const auto copy = folder.path() / "mine.yaml";
  std::filesystem::copy_file(kScenarios / "px4_sitl.yaml", copy);
  const FirmwareScenario scenario = FirmwareScenario::load(copy);
  EXPECT_TRUE(std::filesystem::equivalent(
      scenario.world, cas::test::source_dir() + "/config/worlds/px4_sitl.yaml"));
  EXPECT_TRUE(std::filesystem::equivalent(
      scenario.topology, cas::test::source_dir() + "/config/topologies/px4_sitl.yaml"));
}

TEST(FirmwareScenario, NamesShippedFilesByTheirWholePathInWhatItWrites) {
  const test::TemporaryFolder folder;
  for (const char* kind : {"worlds", "topologies"}) {
    std::filesystem::create_directories(folder.path() / kind);
    std::filesystem::copy_file(
        std::filesystem::path(cas::test::source_dir() + "/config") / kind / "px4_sitl.yaml",
        folder.path() / kind / "px4_sitl.yaml");
  }
  FirmwareScenario scenario;
  scenario.world = folder.path() / "worlds/px4_sitl.yaml";
  scenario.topology = folder.path() / "topologies/px4_sitl.yaml";
  const FirmwarePlaces places{folder.path(), folder.path() / "run", folder.path(),
                              folder.path() / "casd"};
  write_firmware_configs(scenario, places);
  const auto world = base::ConfigNode::load(places.simulator_config());
  const auto vehicle = world.at("vehicles").items().at(0).require<std::string>("vehicle");
  EXPECT_TRUE(std::filesystem::path(vehicle).is_absolute()) << vehicle;
  EXPECT_TRUE(std::filesystem::exists(vehicle)) << vehicle;
  const auto gains = base::ConfigNode::load(places.casd_config()).require<std::string>("gains");
  EXPECT_TRUE(std::filesystem::path(gains).is_absolute()) << gains;
  EXPECT_TRUE(std::filesystem::exists(gains)) << gains;
}

TEST(FirmwareScenario, TakesTheFirmwaresPlaceFromTheEnvironment) {
  EXPECT_EQ(with_variables("a ${X}/b ${Y}", {{"X", "/opt"}, {"Y", "1"}}), "a /opt/b 1");
  EXPECT_EQ(with_variables("plain ${", {}), "plain ${");
  EXPECT_EQ(with_variables("${CAS_NO_SUCH_VARIABLE:-iris}!", {}), "iris!");
  EXPECT_EQ(with_variables("${X:-iris}", {{"X", "none_iris"}}), "none_iris");
  try {
    with_variables("${CAS_NO_SUCH_VARIABLE}/bin/px4", {});
    FAIL() << "a variable that is not set";
  } catch (const base::ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("CAS_NO_SUCH_VARIABLE"), std::string::npos);
  }
}

TEST(FirmwareScenario, SaysWhatWasMissed) {
  FirmwareScenario scenario;
  scenario.height_error_m = 0.5;
  scenario.drift_m = 1.0;
  FirmwareFigures figures;
  EXPECT_EQ(misses(scenario, figures).size(), 2U) << "nothing was measured";
  figures.looks = 10;
  figures.height_error_m = 0.4;
  figures.drift_m = 0.9;
  EXPECT_TRUE(misses(scenario, figures).empty());
  figures.drift_m = 1.1;
  figures.flight_failure = "arm: refused";
  EXPECT_EQ(misses(scenario, figures),
            (std::vector<std::string>{"arm: refused", "drift 1.10 m, limit 1.00 m"}));
}

/// A flight of 10 s: armed, up to 10 m, held there.
FirmwareFigures flown() {
  FirmwareFigures figures;
  const auto add = [&](StepKind kind, int begin, int end, double height_m) {
    Stage stage;
    stage.step.kind = kind;
    stage.begin = base::SimTime(std::chrono::seconds(begin));
    stage.end = base::SimTime(std::chrono::seconds(end));
    stage.reference_m = {0, 0, height_m};
    figures.stages.push_back(stage);
  };
  add(StepKind::kArm, 0, 1, 0);
  add(StepKind::kTakeoff, 1, 5, 10);
  add(StepKind::kHold, 5, 10, 10);
  return figures;
}

/// truth.csv of that flight, which falls from its height at a moment.
std::string truth(double falls_at_s) {
  std::string rows = "t,x,y,z,vx,vy,vz,roll,pitch,yaw,p,q,r,w1,w2,w3,w4\n";
  for (int i = 0; i <= 1000; ++i) {
    const double t = 0.01 * i;
    const double fallen = t > falls_at_s ? t - falls_at_s : 0;
    const double up = t < 1 ? 0 : t < 5 ? 2.5 * (t - 1) : 10;
    const double z = std::max(0.0, up - 0.5 * 9.81 * fallen * fallen);
    const double vz = fallen == 0 ? (t < 1 || t > 5 ? 0 : 2.5) : z > 0 ? -9.81 * fallen : 0;
    rows += std::to_string(t) + ",0,0," + std::to_string(z) + ",0,0," + std::to_string(vz) +
            ",0,0,0,0,0,0,0,0,0,0\n";
  }
  return rows;
}

TEST(FirmwareFlight, ThatCrashedHasFailedWithoutAnyLimit) {
  const test::TemporaryFolder folder;
  FirmwareFigures good = flown();
  add_incidents(folder.write("good.csv", truth(99)), good);
  EXPECT_TRUE(misses({}, good).empty()) << misses({}, good).front();
  FirmwareFigures fallen = flown();
  add_incidents(folder.write("fallen.csv", truth(7)), fallen);
  const std::vector<std::string> missed = misses({}, fallen);
  EXPECT_TRUE(std::ranges::any_of(missed, [](const std::string& sentence) {
    return sentence.find("the vehicle hit the ground at ") == 0;
  })) << testing::PrintToString(missed);
}

TEST(FirmwareFlight, ThatNobodyRecordedHasFailed) {
  const test::TemporaryFolder folder;
  for (const std::filesystem::path& file :
       {folder.path() / "none.csv", folder.write("empty.csv", "t,x\n")}) {
    FirmwareFigures figures = flown();
    add_incidents(file, figures);
    const std::vector<std::string> missed = misses({}, figures);
    ASSERT_EQ(missed.size(), 1U) << file;
    EXPECT_EQ(missed[0].find("the true flight was not recorded: "), 0U) << missed[0];
  }
}

TEST(FirmwareFlight, TellsWhatCasdCounted) {
  FirmwareFigures figures;
  add_losses(nlohmann::json::parse(R"([
      {"tx": {"dropped": {"age": 2, "queue_full": 1}}, "rx": {"lost": 4}},
      {"tx": {"dropped": {"age": 0}}, "rx": {"lost": 5}}])"),
             figures);
  EXPECT_EQ(figures.dropped, 3U);
  EXPECT_EQ(figures.lost, 9U);
}

}  // namespace
}  // namespace cas::hils
