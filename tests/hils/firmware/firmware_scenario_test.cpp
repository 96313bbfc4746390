// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_scenario.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace cas::hils
