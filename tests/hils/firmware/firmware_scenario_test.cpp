// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_scenario.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/error.hpp"
#include "hils/firmware/firmware_figures.hpp"
#include "hils/firmware/firmware_pilot.hpp"
#include "hils/firmware/firmware_verdict.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

const std::filesystem::path kScenarios = cas::test::source_dir() + "/config/scenarios";

TEST(FirmwareScenario, TheShippedOnesAreRead) {
  for (const char* name :
       {"px4_sitl", "px4_sitl_two", "px4_circle", "px4_mission", "px4_hitl", "px4_geofence",
        "px4_reboot", "ardupilot", "ardupilot_two", "ardupilot_mission", "ardupilot_geofence"}) {
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

/// The shipped PX4 scenario with a line put in the place of another.
std::filesystem::path changed(const test::TemporaryFolder& folder, const std::string& line,
                              const std::string& by) {
  std::ifstream in(kScenarios / "px4_sitl.yaml");
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t at = text.find(line);
  EXPECT_NE(at, std::string::npos) << line;
  return folder.write("changed.yaml", text.replace(at, line.size(), by));
}

TEST(FirmwareScenario, GivesPx4ItsStartScript) {
  const auto& firmware = FirmwareScenario::load(kScenarios / "px4_sitl.yaml").firmware;
  ASSERT_EQ(firmware.command.size(), 5U);
  EXPECT_EQ(firmware.command[3], "-s");
  EXPECT_EQ(firmware.command[4], "etc/init.d-posix/rcS");
  EXPECT_NE(firmware.hint.find("PX4_SIM_MODEL"), std::string::npos);
}

TEST(FirmwareScenario, RebootsNoArmedVehicle) {
  const test::TemporaryFolder folder;
  const auto file = changed(folder, "  - land: {timeout_s: 60}", "  - reboot\n  - land");
  try {
    FirmwareScenario::load(file);
    FAIL() << "a reboot in the air";
  } catch (const base::ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("reboot needs a disarmed vehicle"), std::string::npos)
        << error.what();
  }
}

TEST(FirmwareScenario, HoldsATrajectoryToItsReferenceAlone) {
  const test::TemporaryFolder folder;
  const auto file = changed(
      folder, "  - hold: {duration_s: 20, measure: true}",
      "  - trajectory: {shape: circle, size_m: 2, speed_m_s: 1, duration_s: 10, measure: true}");
  try {
    FirmwareScenario::load(file);
    FAIL() << "a limit on the height of a trajectory";
  } catch (const base::ConfigError& error) {
    const std::string said = error.what();
    EXPECT_NE(said.find("limits.drift_m: the measured step is a trajectory"), std::string::npos)
        << said;
  }
}

TEST(FirmwareScenario, GivesTrajectoriesAndMissionsALinkOfCasd) {
  const test::TemporaryFolder folder;
  const auto links_with = [&](const std::string& step) {
    const auto file = changed(folder, "  - land: {timeout_s: 60}", step + "  - land");
    const FirmwareScenario scenario = FirmwareScenario::load(file);
    FirmwarePlaces places{folder.path(), folder.path() / "run", folder.path(),
                          folder.path() / "casd"};
    if (scenario.needs_companion()) places.companions = {4321};
    write_firmware_configs(scenario, places);
    return base::ConfigNode::load(places.casd_config()).at("links").items();
  };
  EXPECT_EQ(links_with("").back().require<std::string>("name"), "gcs");
  const auto links =
      links_with("  - mission: {items: [waypoint: {north_m: 1, east_m: 1, up_m: 3}]}\n");
  EXPECT_EQ(links.back().require<std::string>("name"), companion_link_name(0));
  EXPECT_EQ(links.back().require<std::string>("remote"), "127.0.0.1:4321");
}

TEST(FirmwareScenario, RefusesAVersionThatIsNone) {
  const test::TemporaryFolder folder;
  const auto file = changed(folder, "least_version: \"1.12\"", "least_version: \"v1.12\"");
  EXPECT_THROW(FirmwareScenario::load(file), base::ConfigError);
}

/// The scenario with further keys. @return its world as it is given to hilsim
base::ConfigNode world_with(const test::TemporaryFolder& folder, const std::string& keys) {
  const auto file = changed(folder, "limits:", keys + "\nlimits:");
  const FirmwarePlaces places{folder.path(), folder.path() / "run", folder.path(),
                              folder.path() / "casd"};
  write_firmware_configs(FirmwareScenario::load(file), places);
  return base::ConfigNode::load(places.simulator_config());
}

/// The error on a world with these keys; empty: none.
std::string refusal_of(const std::string& keys) {
  const test::TemporaryFolder folder;
  try {
    world_with(folder, keys);
  } catch (const base::ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(FirmwareScenario, GivesTheWorldsVehicleSensorsWindAndFaults) {
  const test::TemporaryFolder folder;
  const base::ConfigNode world = world_with(folder, R"(
sensors: rtk
plugins:
  - {plugin: wind, mean_m_s: 6, from_deg: 270}
faults:
  - {at_s: 5, gust: {amplitude_m_s: [3, 2, 0], length_m: 20, hold_s: 1}})");
  const base::ConfigNode vehicle = world.at("vehicles").items().at(0);
  EXPECT_EQ(vehicle.require<std::string>("sensors"), "rtk");
  std::string names;
  for (const base::ConfigNode& plugin : vehicle.at("plugins").items()) {
    names += plugin.require<std::string>("plugin") + " ";
    if (names.ends_with("fault ")) {
      EXPECT_EQ(plugin.at("faults").items().size(), 1U);
    }
  }
  EXPECT_EQ(names, "motor imu gps magnetometer barometer mavlink_interface wind fault recorder ");
}

TEST(FirmwareScenario, RefusesFaultsThatItsBenchCannotPlay) {
  struct Case {
    const char* fault;
    const char* sentence;
  };
  for (const auto& [fault, sentence] : {
           Case{"unplug: fcu", "faults[0].unplug: this firmware has no serial line of hils"},
           Case{"line: {packet_loss: 0.1}", "faults[0].line: this firmware has no serial line"},
           Case{"flood_hz: 1000", "faults[0].flood_hz: a flight of stock firmware does not have"},
           Case{"silence: ground", "faults[0].silence: a flight of stock firmware does not have"},
           Case{"cut: px5", "the topology has no link of this name; did you mean 'px4'?"},
           Case{"pause: casd", "faults[0].pause: takes only hilsim"},
       }) {
    const std::string said =
        refusal_of(std::string("faults:\n  - {at_s: 5, for_s: 0.3, ") + fault + "}");
    EXPECT_NE(said.find(sentence), std::string::npos) << said;
    EXPECT_NE(said.find("changed.yaml:"), std::string::npos) << said;
  }
  EXPECT_EQ(refusal_of("faults:\n  - {at_s: 5, for_s: 0.3, cut: px4}"), "");
  EXPECT_NE(refusal_of("faults:\n  - {at_s: 5, for_s: 21, pause: hilsim}").find("for_s"),
            std::string::npos);
}

TEST(FirmwareScenario, RefusesWhatMeansNothingToIt) {
  EXPECT_NE(refusal_of(
                "faults:\n  - {at_s: 5, gust: {amplitude_m_s: [3, 2, 0], length_m: 20, hold_s: 1}}")
                .find("faults[0]: needs 'plugin: wind'"),
            std::string::npos);
}

TEST(FirmwareScenario, RefusesFaultsOfSensorsThatItsWorldDoesNotHave) {
  const test::TemporaryFolder folder;
  std::ifstream in(kScenarios / "ardupilot.yaml");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  for (const char* effect :
       {"drop: gps", "freeze: imu", "scale: {sensor: barometer, pressure: 100}",
        "turn: {sensor: magnetometer, rpy_deg: [0, 0, 90]}"}) {
    const auto file = folder.write("changed.yaml", text + "faults: [{at_s: 5, " + effect + "}]\n");
    try {
      FirmwareScenario::load(file);
      FAIL() << effect;
    } catch (const base::ConfigError& error) {
      const std::string said = error.what();
      EXPECT_NE(said.find("faults[0]: needs 'plugin: "), std::string::npos) << said;
      EXPECT_NE(said.find("it would begin and do nothing"), std::string::npos) << said;
    }
  }
  folder.write("rotor.yaml", text + "faults: [{at_s: 5, rotor: {number: 1, stop: true}}]\n");
  EXPECT_NO_THROW(FirmwareScenario::load(folder.path() / "rotor.yaml"));
}

/// The error on the scenario of two PX4 in which `by` replaces `text`.
std::string refusal_of_two(const std::string& text, const std::string& by) {
  const test::TemporaryFolder folder;
  std::ifstream in(kScenarios / "px4_sitl_two.yaml");
  std::string scenario{std::istreambuf_iterator<char>(in), {}};
  const std::size_t at = scenario.find(text);
  EXPECT_NE(at, std::string::npos) << text;
  const auto file = folder.write("changed.yaml", scenario.replace(at, text.size(), by));
  try {
    FirmwareScenario::load(file);
  } catch (const base::ConfigError& error) {
    return error.what();
  }
  return "";
}

struct Refused {
  const char* name;
  const char* text;
  const char* by;
  const char* sentence;  ///< part of it
};

class SeveralInstances : public testing::TestWithParam<Refused> {};

TEST_P(SeveralInstances, AreRefusedWhereTheyCannotFly) {
  const Refused& refused = GetParam();
  const std::string said = refusal_of_two(refused.text, refused.by);
  EXPECT_NE(said.find(refused.sentence), std::string::npos) << said;
  EXPECT_NE(said.find("changed.yaml:"), std::string::npos) << said;
}

INSTANTIATE_TEST_SUITE_P(
    FirmwareScenario, SeveralInstances,
    testing::Values(Refused{"MoreThanTheWorldHas", "instances: 2", "instances: 3",
                            "firmware.instances: the world has only 2 of them"},
                    Refused{"AllTheSame", "-i, \"${CAS_INSTANCE}\", ", "",
                            "several instances need ${CAS_INSTANCE} in it"},
                    Refused{"OneFolderForAll", "instances: 2", "instances: 2\n  cwd: /tmp/px4",
                            "firmware.cwd: several instances need ${CAS_INSTANCE} in it"},
                    Refused{"OnASerialLine", "instances: 2", "instances: 2\n  on_serial_line: true",
                            "fly in software only"},
                    Refused{"TooMany", "instances: 2", "instances: 17", "firmware.instances"}),
    [](const auto& test) { return test.param.name; });

TEST(FirmwareScenario, OfTwoGivesEachItsFaultsAndItsRecorder) {
  const test::TemporaryFolder folder;
  FirmwareScenario scenario = FirmwareScenario::load(kScenarios / "px4_sitl_two.yaml");
  ASSERT_EQ(scenario.vehicles, (VehicleNames{"left", "right"}));
  scenario.faults = parse_scenario_faults(
      base::ConfigNode::parse("[{at_s: 5, drop: gps, for_s: 1, vehicle: right},"
                              " {at_s: 6, drop: gps, for_s: 1}]",
                              "test"),
      base::ConfigNode::empty(), scenario.vehicles);
  const FirmwarePlaces places{folder.path(), folder.path() / "run", folder.path(),
                              folder.path() / "casd"};
  write_firmware_configs(scenario, places);
  const auto world = base::ConfigNode::load(places.simulator_config());
  std::vector<std::size_t> faults;
  std::vector<std::string> recordings;
  for (const base::ConfigNode& vehicle : world.at("vehicles").items()) {
    for (const base::ConfigNode& plugin : vehicle.at("plugins").items()) {
      const auto name = plugin.require<std::string>("plugin");
      if (name == "fault") faults.push_back(plugin.at("faults").items().size());
      if (name == "recorder") recordings.push_back(plugin.require<std::string>("file"));
    }
  }
  EXPECT_EQ(faults, (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(recordings, (std::vector<std::string>{"truth_left.csv", "truth_right.csv"}));
}

TEST(FirmwareScenario, RefusesAFaultThatAsksForAnUnknownStep) {
  EXPECT_NE(refusal_of("faults:\n  - {when: phase == hodl, drop: gps, for_s: 1}")
                .find("faults[0].when: the scenario has no step 'hodl'; did you mean 'hold'?"),
            std::string::npos);
}

struct BadFence {
  const char* what;
  const char* by;
  const char* sentence;
};

TEST(FirmwareScenario, RefusesAFenceThatWouldNotAct) {
  constexpr std::array kBad{
      BadFence{"geofence: {radius_m: 15, action: hold, margin_m: 5, early_m: 10}", "",
               "steps: a breach step needs the section geofence"},
      BadFence{"  - breach: {north_m: 40, east_m: 0, up_m: 5, speed_m_s: 1, timeout_s: 60}\n", "",
               "geofence: no breach step flies to this fence"},
      BadFence{"north_m: 40", "north_m: 20", "is not beyond the fence and its margin"}};
  for (const auto& [what, by, sentence] : kBad) {
    std::ifstream in(kScenarios / "px4_geofence.yaml");
    std::string text{std::istreambuf_iterator<char>(in), {}};
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    const test::TemporaryFolder folder;
    const auto file = folder.write("changed.yaml", text.replace(at, std::string(what).size(), by));
    try {
      FirmwareScenario::load(file);
      ADD_FAILURE() << sentence;
    } catch (const base::ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(sentence), std::string::npos) << error.what();
    }
  }
}

TEST(FirmwareScenario, RefusesARateOfNoMessage) {
  const test::TemporaryFolder folder;
  const auto file = changed(folder, "  drift_m: 1.5\n", "  rates_hz: {ATTITUTE: 10}\n");
  EXPECT_THROW(FirmwareScenario::load(file), base::ConfigError);
}

TEST(FirmwareScenario, ComparesVersionsByTheirNumbers) {
  EXPECT_TRUE(is_at_least("1.16.1", "1.12"));
  EXPECT_TRUE(is_at_least("1.12.0", "1.12"));
  EXPECT_TRUE(is_at_least("4.5.6", ""));
  EXPECT_FALSE(is_at_least("1.9.2", "1.12"));
  EXPECT_FALSE(is_at_least("1.11.3", "1.12"));
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

std::vector<std::string> failures(const FirmwareScenario& scenario,
                                  const FirmwareFigures& figures) {
  return judge(scenario, figures).failures;
}

TEST(FirmwareScenario, SaysWhatWasMissed) {
  FirmwareScenario scenario;
  scenario.height_error_m = 0.5;
  scenario.drift_m = 1.0;
  FirmwareFigures figures;
  EXPECT_EQ(failures(scenario, figures).size(), 2U) << "nothing was measured";
  figures.height_error_m = 0.4;
  figures.drift_m = 0.9;
  EXPECT_TRUE(failures(scenario, figures).empty());
  figures.drift_m = 1.1;
  figures.flight_failure = "arm: refused";
  EXPECT_EQ(failures(scenario, figures),
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
  add_truth(folder.write("good.csv", truth(99)), good);
  EXPECT_TRUE(failures({}, good).empty()) << failures({}, good).front();
  FirmwareFigures fallen = flown();
  add_truth(folder.write("fallen.csv", truth(7)), fallen);
  const std::vector<std::string> missed = failures({}, fallen);
  EXPECT_TRUE(std::ranges::any_of(missed, [](const std::string& sentence) {
    return sentence.find("hit the ground at ") != std::string::npos;
  })) << testing::PrintToString(missed);
}

TEST(FirmwareFlight, HasTheRmsOfItsMeasuredHold) {
  const test::TemporaryFolder folder;
  FirmwareFigures figures = flown();
  figures.stages.back().step.measure = true;
  add_truth(folder.write("good.csv", truth(99)), figures);
  ASSERT_TRUE(figures.rms);
  EXPECT_NEAR(figures.rms->z_m, 0, 1e-9);
  EXPECT_NEAR(static_cast<double>(figures.rms->samples), 500, 1);
}

/// truth.csv of that flight, whose hold swings about its height.
std::string swinging_truth() {
  std::string rows = "t,x,y,z,vx,vy,vz,roll,pitch,yaw,p,q,r,w1,w2,w3,w4\n";
  for (int i = 0; i <= 1000; ++i) {
    const double t = 0.01 * i;
    const double up = t < 1 ? 0 : t < 5 ? 2.5 * (t - 1) : 10 + 1.8 * std::sin(2 * M_PI * (t - 5));
    rows += std::to_string(t) + ",0,0," + std::to_string(up) + ",0,0,0,0,0,0,0,0,0,0,0,0,0\n";
  }
  return rows;
}

TEST(FirmwareFlight, ThatSwingsAboutItsHeightMissesItsLimitsAlthoughTheMeanIsRight) {
  const test::TemporaryFolder folder;
  FirmwareScenario scenario = FirmwareScenario::load(kScenarios / "px4_sitl.yaml");
  std::erase_if(scenario.limits.figures,
                [](const auto& limit) { return limit.first.starts_with("rms_estimate_"); });
  FirmwareFigures figures = flown();
  figures.stages.back().step.measure = true;
  add_truth(folder.write("truth.csv", swinging_truth()), figures);
  EXPECT_NEAR(figures.height_error_m.value(), 0, 0.02);
  EXPECT_NEAR(figures.peak_error_m.value(), 1.8, 0.02);
  EXPECT_EQ(failures(scenario, figures),
            (std::vector<std::string>{
                "RMS error of the true position, z_m: 1.2728 m; the limit is 0.2 m",
                "largest error of the true position: 1.800 m; the limit is 0.6 m"}));
}

/// The vehicle was disarmed before it took off.
FirmwareFigures never_left_the_ground() {
  FirmwareFigures figures;
  figures.flight_failure = "the vehicle was disarmed before it took off, during step 2 (takeoff)";
  figures.disarmed_on_ground = true;
  return figures;
}

TEST(FirmwareFlight, ThatEndsOnTheGroundUnhurtHasNoVerdict) {
  const Verdict verdict = judge({}, never_left_the_ground());
  EXPECT_EQ(verdict.exit_code(), kExitInvalid);
  EXPECT_EQ(verdict.failures,
            (std::vector<std::string>{
                "the vehicle was disarmed before it took off, during step 2 (takeoff); it stands "
                "upright and unhurt, no fault has struck, and hils does not arm it again: the "
                "flight has no verdict"}));
}

struct Harm {
  const char* name;
  void (*strike)(FirmwareFigures&);
};

class HarmedOnTheGround : public testing::TestWithParam<Harm> {};

TEST_P(HarmedOnTheGround, HasFailed) {
  FirmwareFigures figures = never_left_the_ground();
  GetParam().strike(figures);
  const Verdict verdict = judge({}, figures);
  EXPECT_EQ(verdict.exit_code(), kExitLimitsMissed);
  ASSERT_FALSE(verdict.failures.empty());
  EXPECT_EQ(verdict.failures.front(), *figures.flight_failure);
}

INSTANTIATE_TEST_SUITE_P(
    FirmwareFlight, HarmedOnTheGround,
    testing::Values(Harm{"TippedOver", [](FirmwareFigures& f) { f.disarmed_on_ground = false; }},
                    Harm{"Struck",
                         [](FirmwareFigures& f) {
                           f.incidents = {{IncidentKind::kStrike, 5, "hit something with rotor 1"}};
                         }},
                    Harm{"AfterAFault", [](FirmwareFigures& f) { f.faults.emplace_back(); }},
                    Harm{"Unwatched", [](FirmwareFigures& f) { f.unwatched = "no truth.csv"; }}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(FirmwareFlight, WithoutALimitOnItsMotionSaysSo) {
  FirmwareScenario scenario;
  scenario.drift_m = 1;
  FirmwareFigures figures = flown();
  figures.drift_m = 0.5;
  EXPECT_TRUE(judge(scenario, figures).passed);
  EXPECT_EQ(judge(scenario, figures).remarks.size(), 1U);
  scenario.limits.figures["peak_error_m"] = 1;
  figures.peak_error_m = 0.5;
  EXPECT_TRUE(judge(scenario, figures).remarks.empty());
}

TEST(FirmwareFlight, HasNoFigureOfAHoldThatItDidNotFly) {
  const test::TemporaryFolder folder;
  FirmwareFigures figures = flown();
  figures.under_way = figures.stages.back();
  figures.under_way->step.measure = true;
  figures.stages.pop_back();
  figures.flight_failure = "step 3 (hold) ended";
  add_truth(folder.write("truth.csv", truth(99)), figures);
  const std::array results{FirmwareResult{"iris0", figures, judge({}, figures)}};
  const auto summary = firmware_summary({}, results);
  for (const char* key : {"height_error_m", "drift_m", "peak_error_m", "rms", "rms_estimate"}) {
    EXPECT_TRUE(summary.at(key).is_null()) << key;
  }
}

TEST(FirmwareFlight, HasTheRmsOfItsHeadingAboutTheMeanHeading) {
  const test::TemporaryFolder folder;
  std::string rows = "t,x,y,z,vx,vy,vz,roll,pitch,yaw,p,q,r,w1,w2,w3,w4\n";
  for (int i = 0; i < 1000; ++i) {  // to and fro about the angle where its numbers leap
    rows += std::to_string(0.01 * i) + ",0,0,10,0,0,0,0,0," + (i % 2 == 0 ? "3.0416" : "-3.0416") +
            ",0,0,0,0,0,0,0\n";
  }
  FirmwareFigures figures = flown();
  figures.stages.back().step.measure = true;
  add_truth(folder.write("truth.csv", rows), figures);
  ASSERT_TRUE(figures.rms);
  EXPECT_NEAR(figures.rms->yaw_rad, 0.1, 1e-3);
}

PoseSample sample(double time_s, Pose pose) {
  return {.time_us = static_cast<std::int64_t>(1e6 * time_s), .pose = pose};
}

TEST(FirmwareFlight, ComparesEstimateAndTruthByWhatTheyWereBeforeTakeoff) {
  FirmwareFigures figures = flown();  // takeoff from 1 s, hold from 5 to 10 s
  figures.stages.back().step.measure = true;
  std::vector<PoseSample> truth;
  std::vector<PoseSample> estimate;
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.01 * i;
    truth.push_back(sample(t, {.x_m = 1, .z_m = t < 1 ? 0.0 : 5.0, .yaw_rad = 0.5}));
    // Its origin is 3 m off; in the air it is 0.2 m too high and 0.1 rad off.
    estimate.push_back(
        sample(t, {.x_m = 4, .z_m = t < 1 ? 0.0 : 5.2, .yaw_rad = t < 1 ? 0.5 : 0.6}));
  }
  const auto error = estimate_error(figures.stages, truth, estimate);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->x_m, 0, 1e-9);
  EXPECT_NEAR(error->z_m, 0.2, 1e-9);
  EXPECT_NEAR(error->yaw_rad, 0.1, 1e-9);
  EXPECT_FALSE(estimate_error(figures.stages, truth, {}));
  FlightStep& takeoff = figures.stages[1].step;
  takeoff.kind = StepKind::kMission;
  takeoff.mission.items = {{.command = mavlink::common::MavCmd::kNavTakeoff}};
  EXPECT_TRUE(estimate_error(figures.stages, truth, estimate)) << "a mission that takes off";
}

TEST(FirmwareFlight, IsHeldToRatesHopsAndEstimate) {
  FirmwareScenario scenario;
  scenario.rates_hz = {{"ATTITUDE", 20}};
  scenario.hop_p99_us = 500;
  scenario.limits.figures["rms_estimate_z_m"] = 0.1;
  FirmwareFigures figures = flown();
  EXPECT_EQ(failures(scenario, figures).size(), 3U) << "nothing was measured";
  figures.rates_hz = {{"ATTITUDE", 19}};
  figures.hops = R"([{"link": "gcs", "routes": [{"from": "px4", "p99": 900.0}]}])";
  figures.rms_estimate = RmsFigures{.z_m = 0.2, .samples = 10};
  EXPECT_EQ(
      failures(scenario, figures),
      (std::vector<std::string>{"RMS error of the estimate, z_m: 0.2000 m; the limit is 0.1 m",
                                "slowest way through casd, 99 % 900 us, limit 500 us",
                                "rate of ATTITUDE 19.0 Hz, limit 20.0 Hz"}));
  figures.rates_hz = {{"ATTITUDE", 21}};
  figures.hops = R"([{"link": "gcs", "routes": [{"from": "px4", "p99": 400.0}]}])";
  figures.rms_estimate->z_m = 0.05;
  EXPECT_TRUE(failures(scenario, figures).empty());
}

TEST(FirmwareFlight, IsNotFlownOnAVersionThatIsTooOldOrNotTold) {
  Firmware wanted;
  EXPECT_EQ(version_fault(wanted, ""), std::nullopt);
  wanted.least_version = "1.12";
  EXPECT_EQ(version_fault(wanted, "1.12.0"), std::nullopt);
  EXPECT_EQ(version_fault(wanted, "1.11.3"),
            "the firmware is v1.11.3, and firmware.least_version is 1.12");
  EXPECT_EQ(version_fault(wanted, ""),
            "the firmware did not tell its version within 20 s, and firmware.least_version is "
            "1.12");
  EXPECT_EQ(version_fault(wanted, "1.8.0"), std::nullopt) << "PX4's word for a tree without tags";
  EXPECT_EQ(version_fault(wanted, "0.0.0"), std::nullopt);
}

TEST(FirmwareFlight, HasADigestOfItsParametersWhateverTheirOrder) {
  const auto list = [](const char* text) { return nlohmann::json::parse(text); };
  const ParamDigest digest = digest_of(list(R"([{"name": "A", "value": 1}, {"name": "B",
                                                "value": 2.5}])"));
  EXPECT_EQ(digest.count, 2U);
  EXPECT_EQ(digest.sha256.size(), 64U);
  EXPECT_EQ(digest_of(list(R"([{"name": "B", "value": 2.5}, {"name": "A", "value": 1}])")).sha256,
            digest.sha256);
  EXPECT_NE(digest_of(list(R"([{"name": "A", "value": 2}, {"name": "B", "value": 2.5}])")).sha256,
            digest.sha256);
}

TEST(FirmwareFlight, DoesNotWaitForAVehicleThatHasFallenSilent) {
  EXPECT_EQ(silence_fault({.heard = true, .heartbeat_age_s = 29}), std::nullopt);
  EXPECT_TRUE(silence_fault({.heard = true, .heartbeat_age_s = 31}));
  EXPECT_TRUE(silence_fault({}));
}

TEST(FirmwareFlight, IsJudgedUnderTheSameNamesWhateverComesOut) {
  FirmwareScenario scenario;
  scenario.drift_m = 1;
  FirmwareFigures figures = flown();
  figures.drift_m = 0.5;
  const auto names = [&] {
    std::string all;
    for (const LimitCheck& each : judge(scenario, figures).checks) all += each.what + " ";
    return all;
  };
  EXPECT_TRUE(judge(scenario, figures).passed);
  const std::string good = names();
  EXPECT_EQ(good, "flight drift steps by the true flight incidents true flight ");
  figures.drift_m = 2;
  figures.flight_failure = "land was not done within 60 s";
  EXPECT_EQ(judge(scenario, figures).exit_code(), kExitLimitsMissed);
  EXPECT_EQ(names(), good);
}

/// The verdict on a vehicle that turned 7.25 m from home, its fence being at 15 m.
Verdict turned_early(const std::string& version) {
  FirmwareScenario scenario;
  scenario.fence = Geofence{.radius_m = 15, .margin_m = 5, .early_m = 10};
  FirmwareFigures figures = flown();
  figures.version = version;
  figures.fence = FenceFigures{.words = "Geofence", .farthest_m = 7.25, .highest_m = 5};
  figures.stages.back().step.kind = StepKind::kBreach;
  return judge(scenario, figures);
}

TEST(FirmwareFlight, MayTurnFarAheadOfItsFenceOnlyWithAFirmwareThatLooksAhead) {
  EXPECT_TRUE(turned_early("1.12.0").passed);
  EXPECT_EQ(turned_early("1.16.1").failures,
            std::vector<std::string>{
                "the vehicle did not come within 5.0 m of its fence: 7.25 m from home at most"});
}

TEST(FirmwareFlight, ThatBrokeOffDoesNotJudgeTheLimitsItDidNotReach) {
  FirmwareScenario scenario;
  scenario.drift_m = 1;
  scenario.limits.figures = {{"rms_z_m", 0.1}, {"rms_estimate_z_m", 0.1}, {"peak_error_m", 1}};
  scenario.rates_hz = {{"ATTITUDE", 20}};
  scenario.hop_p99_us = 500;
  FirmwareFigures figures = flown();
  figures.flight_failure = "step 2 (takeoff) was not done within 60 s";
  figures.under_way = figures.stages.back();
  const Verdict verdict = judge(scenario, figures);
  EXPECT_EQ(verdict.failures, std::vector<std::string>{*figures.flight_failure});
  EXPECT_EQ(verdict.exit_code(), kExitLimitsMissed);
  int not_reached = 0;
  for (const LimitCheck& each : verdict.checks) {
    if (each.judged) continue;
    ++not_reached;
    EXPECT_TRUE(each.bound) << each.what;
    EXPECT_EQ(each.found, "not reached") << each.what;
  }
  EXPECT_EQ(not_reached, 6);
  const std::array results{FirmwareResult{"iris0", figures, verdict}};
  const auto stages = firmware_summary(scenario, results).at("stages");
  EXPECT_EQ(stages.back().at("finished"), false);
}

TEST(FirmwareFlight, WithoutItsFaultHasNoVerdictWhereItWouldHavePassed) {
  FirmwareFigures figures = flown();
  figures.never_began = {{.name = "squall"}};
  const Verdict verdict = judge({}, figures);
  EXPECT_EQ(verdict.exit_code(), kExitInvalid);
  EXPECT_EQ(verdict.failures,
            std::vector<std::string>{"fault 'squall' never began: its condition never came true"});
  const std::array results{FirmwareResult{"iris0", figures, verdict}};
  EXPECT_EQ(firmware_summary({}, results).at("faults").at(0).at("began"), "never");
  figures.flight_failure = "arm: refused";
  const Verdict failed = judge({}, figures);
  EXPECT_EQ(failed.exit_code(), kExitLimitsMissed);
  EXPECT_EQ(failed.failures.front(), "arm: refused");
}

TEST(FirmwareFlight, ThatNobodyRecordedHasFailed) {
  const test::TemporaryFolder folder;
  for (const std::filesystem::path& file :
       {folder.path() / "none.csv", folder.write("empty.csv", "t,x\n")}) {
    FirmwareFigures figures = flown();
    add_truth(file, figures);
    const std::vector<std::string> missed = failures({}, figures);
    ASSERT_EQ(missed.size(), 1U) << file;
    EXPECT_EQ(missed[0].find("the true flight was not recorded: "), 0U) << missed[0];
  }
}

TEST(FirmwareFlight, WhoseRecordHasAHoleHasFailed) {
  struct Case {
    const char* sentence;
    double from_s, to_s;  ///< rows that are missing
  };
  const test::TemporaryFolder folder;
  for (const auto& [sentence, from_s, to_s] :
       {Case{"it ends at 6.99 s, and the flight at 10.00 s", 7, 99},
        Case{"it has nothing between 5.99 s and 8.00 s", 6, 8},
        Case{"it begins at 2.00 s, and the flight at 0.00 s", -1, 2}}) {
    std::string rows;
    std::istringstream all(truth(99));
    for (std::string line; std::getline(all, line);) {
      const double t = line.starts_with("t") ? -2 : std::stod(line);
      if (t < from_s || t >= to_s) rows += line + "\n";
    }
    FirmwareFigures figures = flown();
    add_truth(folder.write("hole.csv", rows), figures);
    const std::vector<std::string> missed = failures({}, figures);
    ASSERT_FALSE(missed.empty()) << sentence;
    EXPECT_NE(missed.back().find(sentence), std::string::npos) << missed.back();
  }
}

TEST(FirmwareFlight, WhoseFaultCameAfterItsEndWasFlownWithoutIt) {
  const auto faults = parse_scenario_faults(
      base::ConfigNode::parse("[{at_s: 11, drop: gps, for_s: 1, name: late}]", "test"),
      base::ConfigNode::empty());
  const auto never_with_begin = [&](int seconds) {
    const BenchFaultScript::Span span{
        .name = "late", .begin = base::SimTime(std::chrono::seconds(seconds)), .end = {}};
    return faults_that_never_began(faults, 0, {span}, flown().stages).size();
  };
  EXPECT_EQ(never_with_begin(9), 0U);
  EXPECT_EQ(never_with_begin(11), 1U) << "the programs ran on";
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
