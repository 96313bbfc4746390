// SPDX-License-Identifier: BSD-3-Clause

#include <gmock/gmock.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>

#include "base/error.hpp"
#include "hils/firmware/firmware_composition.hpp"
#include "hils/programs/composed_parts.hpp"
#include "hils/scenario/scenario.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using testing::HasSubstr;

const std::filesystem::path kScenarios = cas::test::source_dir() + "/config/scenarios";

TEST(FirmwareScenario, TheShippedOnesAreRead) {
  for (const char* name : {"px4_sitl",
                           "px4_sitl_two",
                           "px4_circle",
                           "px4_mission",
                           "px4_hitl",
                           "px4_geofence",
                           "px4_reboot",
                           "px4_plane",
                           "px4_vtol",
                           "px4_vtol_hitl",
                           "px4_tiltrotor",
                           "px4_tailsitter",
                           "px4_odometry",
                           "ardupilot",
                           "ardupilot_two",
                           "ardupilot_mission",
                           "ardupilot_geofence",
                           "ardupilot_plane",
                           "ardupilot_quadplane",
                           "px4_precision_landing",
                           "ardupilot_precision_landing",
                           "px4_wall",
                           "ardupilot_wall",
                           "ardupilot_terrain",
                           "ardupilot_terrain_range"}) {
    const auto file = kScenarios / (std::string(name) + ".yaml");
    const Scenario scenario = Scenario::load(file);
    ASSERT_TRUE(scenario.firmware) << name;
    EXPECT_EQ(scenario.name, name);
    EXPECT_FALSE(scenario.firmware->command.empty());
    EXPECT_EQ(scenario.firmware->not_hil, !scenario.firmware->on_serial_line)
        << "only firmware without a wire is armed without the HIL flag";
  }
  EXPECT_FALSE(Scenario::load(kScenarios / "hover.yaml").firmware);
}

TEST(FirmwareScenario, OfLiveOutputsNeedsTheUsersWord) {
  const test::TemporaryFolder folder;
  const auto refusal_without = [&](const std::string& line) {
    std::ifstream in(kScenarios / "ardupilot_hil.yaml");
    std::string text{std::istreambuf_iterator<char>(in), {}};
    for (const char* kind : {"world", "topology"}) {
      const std::string before = std::string(kind) + ": ../";
      text.replace(text.find(before), before.size(),
                   std::string(kind) + ": " + test::source_dir() + "/config/");
    }
    const std::size_t at = text.find(line);
    EXPECT_NE(at, std::string::npos) << line;
    const auto file = folder.write("changed.yaml", text.replace(at, line.size(), ""));
    return test::refusal([&] { Scenario::load(file); });
  };
  EXPECT_THAT(refusal_without("  outputs_disconnected: true\n"),
              HasSubstr("firmware: needs outputs_disconnected: true"));
  EXPECT_THAT(refusal_without("  on_serial_line: true"), HasSubstr("needs on_serial_line: true"));

  const Firmware firmware = *Scenario::load(kScenarios / "ardupilot_hil.yaml").firmware;
  EXPECT_TRUE(firmware.external_ahrs);
  EXPECT_TRUE(firmware.not_hil) << "consent follows from the word";
  EXPECT_EQ(firmware.autopilot, "ArduPilot");
  EXPECT_TRUE(Scenario::load(kScenarios / "ardupilot_hil_plane.yaml").firmware->external_ahrs);
}

TEST(FirmwareScenario, OnABoardTakesItsPorts) {
  const test::TemporaryFolder folder;
  RunRequest request{.scenario = Scenario::load(kScenarios / "ardupilot_hil.yaml")};
  FcuDevice& board = request.fcu_devices[0];
  board = {.path = "/dev/board", .baud = 57600, .sensors_path = "/dev/sensors"};
  const auto said = [&] { return test::refusal([&] { check_firmware_board(request); }); };
  EXPECT_THAT(said(), HasSubstr("needs outputs_disconnected: true"));
  board.outputs_disconnected = true;
  board.sensors_path.clear();
  EXPECT_THAT(said(), HasSubstr("needs sensors_device"));
  board.sensors_path = "/dev/sensors";
  EXPECT_NO_THROW(check_firmware_board(request));

  const RunPaths paths = RunPaths::of(request.scenario, folder.path(), folder.path());
  write_firmware_configs(request, paths);
  const auto link = base::ConfigNode::load(paths.casd_config()).at("links").items().at(1);
  EXPECT_EQ(link.require<std::string>("device"), "/dev/board");
  EXPECT_EQ(link.require<int>("baud"), 57600);
  const auto world = base::ConfigNode::load(paths.simulator_config());
  for (const auto& plugin : world.at("vehicles").items().at(0).at("plugins").items()) {
    if (plugin.require<std::string>("plugin") != "external_ahrs") continue;
    EXPECT_EQ(plugin.require<std::string>("device"), "/dev/sensors");
    EXPECT_FALSE(plugin.has("pty"));
  }
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

TEST(FirmwareScenario, ThatHasAHilModeHasNoWordAboutItsOutputs) {
  const test::TemporaryFolder folder;
  const auto file = changed(folder, "firmware:\n", "firmware:\n  outputs_disconnected: true\n");
  EXPECT_THAT(test::refusal([&] { Scenario::load(file); }),
              HasSubstr("is for a world with plugin external_ahrs"));
}

TEST(FirmwareScenario, GivesPx4ItsStartScript) {
  const Firmware firmware = *Scenario::load(kScenarios / "px4_sitl.yaml").firmware;
  ASSERT_EQ(firmware.command.size(), 5U);
  EXPECT_EQ(firmware.command[3], "-s");
  EXPECT_EQ(firmware.command[4], "etc/init.d-posix/rcS");
  EXPECT_THAT(firmware.hint, HasSubstr("PX4_SIM_MODEL"));
}

TEST(FirmwareScenario, RebootsNoArmedVehicle) {
  const test::TemporaryFolder folder;
  const auto file = changed(folder, "  - land: {timeout_s: 60}", "  - reboot\n  - land");
  EXPECT_THAT(test::refusal([&] { Scenario::load(file); }),
              HasSubstr("reboot needs a disarmed vehicle"));
}

TEST(FirmwareScenario, HoldsATrajectoryToItsReferenceAlone) {
  const test::TemporaryFolder folder;
  const auto file = changed(
      folder, "  - hold: {duration_s: 20, measure: true}",
      "  - trajectory: {shape: circle, size_m: 2, speed_m_s: 1, duration_s: 10, measure: true}");
  EXPECT_THAT(test::refusal([&] { Scenario::load(file); }),
              HasSubstr("limits.drift_m: the measured step is a trajectory"));
}

TEST(FirmwareScenario, GivesTrajectoriesAndMissionsALinkOfCasd) {
  const test::TemporaryFolder folder;
  const auto links_with = [&](const std::string& step) {
    const auto file = changed(folder, "  - land: {timeout_s: 60}", step + "  - land");
    const Scenario scenario = Scenario::load(file);
    RunPaths paths = RunPaths::of(scenario, folder.path(), folder.path());
    if (needs_companion(scenario)) paths.companions = {4321};
    write_firmware_configs({.scenario = scenario}, paths);
    return base::ConfigNode::load(paths.casd_config()).at("links").items();
  };
  EXPECT_EQ(links_with("").back().require<std::string>("name"), "gcs");
  const auto links =
      links_with("  - mission: {items: [waypoint: {north_m: 1, east_m: 1, up_m: 3}]}\n");
  EXPECT_EQ(links.back().require<std::string>("name"), companion_link_name(0));
  EXPECT_EQ(links.back().require<std::string>("remote"), "127.0.0.1:4321");
}

/// A link without routes would hear nothing of the mission's items.
TEST(FirmwareScenario, RoutesItsOwnLinkAsThatOfAStation) {
  const test::TemporaryFolder folder;
  const Scenario scenario = Scenario::load(kScenarios / "ardupilot_hil.yaml");
  RunPaths paths = RunPaths::of(scenario, folder.path(), folder.path());
  ASSERT_TRUE(needs_companion(scenario)) << "it flies a mission";
  paths.companions = {4321};
  write_firmware_configs({.scenario = scenario}, paths);
  std::string routes;
  const auto topology = base::ConfigNode::load(paths.casd_config());
  for (const auto& route : topology.at("routes").items()) {
    routes += route.require<std::string>("from") + ">" + route.require<std::string>("to") + " ";
  }
  EXPECT_NE(routes.find("fcu>hils_companion hils_companion>fcu"), std::string::npos) << routes;
}

TEST(FirmwareScenario, RefusesAVersionThatIsNone) {
  const test::TemporaryFolder folder;
  const auto file = changed(folder, "least_version: \"1.12\"", "least_version: \"v1.12\"");
  EXPECT_THROW(Scenario::load(file), base::ConfigError);
}

/// The world as it is given to hilsim.
base::ConfigNode composed(const test::TemporaryFolder& folder, const RunRequest& request) {
  const RunPaths paths = RunPaths::of(request.scenario, folder.path(), folder.path());
  write_firmware_configs(request, paths);
  return base::ConfigNode::load(paths.simulator_config());
}

/// The scenario with further keys. @return its world as it is given to hilsim
base::ConfigNode world_with(const test::TemporaryFolder& folder, const std::string& keys) {
  const auto file = changed(folder, "limits:", keys + "\nlimits:");
  return composed(folder, {.scenario = Scenario::load(file)});
}

/// The error on a world with these keys; empty: none.
std::string refusal_of(const std::string& keys) {
  const test::TemporaryFolder folder;
  return test::refusal([&] { world_with(folder, keys); });
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
           Case{"silence: sticks", "faults[0].silence: no sticks can be lost: no step `sticks`"},
           Case{"cut: px5", "the topology has no link of this name; did you mean 'px4'?"},
           Case{"pause: casd", "faults[0].pause: takes only hilsim"},
       }) {
    const std::string said =
        refusal_of(std::string("faults:\n  - {at_s: 5, for_s: 0.3, ") + fault + "}");
    EXPECT_THAT(said, HasSubstr(sentence));
    EXPECT_THAT(said, HasSubstr("changed.yaml:"));
  }
  EXPECT_EQ(refusal_of("faults:\n  - {at_s: 5, for_s: 0.3, cut: px4}"), "");
  EXPECT_THAT(refusal_of("faults:\n  - {at_s: 5, for_s: 21, pause: hilsim}"), HasSubstr("for_s"));
}

TEST(FirmwareScenario, RefusesWhatMeansNothingToIt) {
  EXPECT_THAT(
      refusal_of(
          "faults:\n  - {at_s: 5, gust: {amplitude_m_s: [3, 2, 0], length_m: 20, hold_s: 1}}"),
      HasSubstr("faults[0]: needs 'plugin: wind'"));
}

TEST(FirmwareScenario, RefusesFaultsOfSensorsThatItsWorldDoesNotHave) {
  const test::TemporaryFolder folder;
  std::ifstream in(kScenarios / "ardupilot.yaml");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  for (const char* effect : {"drop: gps", "freeze: imu", "disconnect: external_ahrs",
                             "scale: {sensor: barometer, pressure: 100}",
                             "turn: {sensor: magnetometer, rpy_deg: [0, 0, 90]}"}) {
    const auto file = folder.write("changed.yaml", text + "faults: [{at_s: 5, " + effect + "}]\n");
    const std::string said = test::refusal([&] { Scenario::load(file); });
    EXPECT_THAT(said, HasSubstr("faults[0]: needs 'plugin: ")) << effect << ": " << said;
    EXPECT_THAT(said, HasSubstr("it would begin and do nothing")) << effect << ": " << said;
  }
  folder.write("rotor.yaml", text + "faults: [{at_s: 5, rotor: {number: 1, stop: true}}]\n");
  EXPECT_NO_THROW(Scenario::load(folder.path() / "rotor.yaml"));
}

/// The error on the scenario of two PX4 in which `by` replaces `text`.
std::string refusal_of_two(const std::string& text, const std::string& by) {
  const test::TemporaryFolder folder;
  std::ifstream in(kScenarios / "px4_sitl_two.yaml");
  std::string scenario{std::istreambuf_iterator<char>(in), {}};
  const std::size_t at = scenario.find(text);
  EXPECT_NE(at, std::string::npos) << text;
  const auto file = folder.write("changed.yaml", scenario.replace(at, text.size(), by));
  return test::refusal([&] { Scenario::load(file); });
}

TEST(SeveralInstances, AreRefusedWhereTheyCannotFly) {
  struct Refused {
    const char* name;
    const char* text;
    const char* by;
    const char* sentence;  ///< part of it
  };
  const Refused rows[] = {{"ByAKeyThatIsNone", "autopilot: PX4", "instances: 2",
                           "firmware.instances: is no longer a key: each vehicle of the world"},
                          {"AllTheSame", "-i, \"${CAS_INSTANCE}\", ", "",
                           "several instances need ${CAS_INSTANCE} in it"},
                          {"OneFolderForAll", "autopilot: PX4", "autopilot: PX4\n  cwd: /tmp/px4",
                           "firmware.cwd: several instances need ${CAS_INSTANCE} in it"},
                          {"OnASerialLine", "autopilot: PX4",
                           "autopilot: PX4\n  on_serial_line: true", "fly in software only"},
                          {"ByAnAutopilotThatIsNone", "autopilot: PX4", "autopilot: px4",
                           "firmware.autopilot: is PX4 or ArduPilot"},
                          {"ByNoAutopilot", "  autopilot: PX4\n", "", "autopilot"},
                          {"WithKeysOfOurController", "pose: {x_m: 5, y_m: 0}",
                           "pose: {x_m: 5, y_m: 0}, controller: {stamp: arrival}",
                           "vehicles[1].controller: stock firmware has parameters of its own"},
                          {"WithoutAPlace", "home: {", "# home: {", "home"}};
  for (const auto& refused : rows) {
    SCOPED_TRACE(refused.name);
    const std::string said = refusal_of_two(refused.text, refused.by);
    EXPECT_THAT(said, HasSubstr(refused.sentence));
    EXPECT_THAT(said, HasSubstr("changed.yaml:"));
  }
}

/// A node's value as JSON-like text, whatever style it was written in.
std::string plain(const base::ConfigNode& node) {
  if (node.is_map()) {
    std::map<std::string, std::string> entries;
    for (const auto& [name, value] : node.entries()) entries[name] = plain(value);
    std::string text = "{";
    for (const auto& [name, value] : entries) text += name + ": " + value + ", ";
    return text + "}";
  }
  if (node.is_list()) {
    std::string text = "[";
    for (const base::ConfigNode& item : node.items()) text += plain(item) + ", ";
    return text + "]";
  }
  const auto word = node.as<std::string>();
  char* end = nullptr;
  const double number = std::strtod(word.c_str(), &end);
  return *end == 0 && !word.empty() ? std::to_string(number) : word;
}

/// What a user starts by hand and what hils makes are the same simulation.
TEST(MadeForNamedVehicles, TheWorldIsTheShippedOne) {
  struct MadeWorld {
    const char* autopilot;
    const char* world;
  };
  const MadeWorld rows[] = {{"autopilot: PX4", "px4_sitl.yaml"},
                            {"autopilot: PX4, on_serial_line: true", "px4_hitl.yaml"},
                            {"autopilot: ArduPilot", "ardupilot.yaml"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.autopilot);
    const test::TemporaryFolder folder;
    const auto config = cas::test::source_dir() + "/config";
    const auto shipped = base::ConfigNode::load(config + "/worlds/" + row.world);
    const auto name = shipped.at("vehicles").items().front().require<std::string>("name");
    const auto file =
        folder.write("own.yaml", "schema: 1\nvehicle: " + config +
                                     "/vehicles/iris_px4.yaml\ndecimal_year: 2026.5\n"
                                     "home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}\n"
                                     "firmware: {command: [x], " +
                                     row.autopilot +
                                     "}\nsteps: [arm, takeoff: {altitude_m: 2}, hold: {duration_s: "
                                     "1, measure: true}, land]\n");
    const base::ConfigNode made = Scenario::load(file).firmware->world;
    for (const auto& [key, value] : shipped.entries()) {
      if (key == "vehicles") continue;
      EXPECT_EQ(plain(made.at(key)), plain(value)) << key;
    }
    const auto plugins_of = [](const base::ConfigNode& world) {
      std::vector<std::string> names;
      for (const auto& plugin : world.at("vehicles").items().front().at("plugins").items()) {
        names.push_back(plugin.require<std::string>("plugin") + " " +
                        plugin.get<std::string>("transport", ""));
      }
      return names;
    };
    EXPECT_EQ(plugins_of(made), plugins_of(shipped));
  }
}

TEST(FirmwareScenario, OfTwoGivesEachItsFaultsAndItsRecorder) {
  const test::TemporaryFolder folder;
  Scenario scenario = Scenario::load(kScenarios / "px4_sitl_two.yaml");
  ASSERT_EQ(scenario.names(), (VehicleNames{"left", "right"}));
  scenario.faults = parse_scenario_faults(
      base::ConfigNode::parse("[{at_s: 5, drop: gps, for_s: 1, vehicle: right},"
                              " {at_s: 6, drop: gps, for_s: 1}]",
                              "test"),
      base::ConfigNode::empty(), scenario.names());
  const base::ConfigNode world = composed(folder, {.scenario = scenario});
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
  EXPECT_THAT(refusal_of("faults:\n  - {when: phase == hodl, drop: gps, for_s: 1}"),
              HasSubstr("faults[0].when: the scenario has no step 'hodl'; did you mean 'hold'?"));
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
    const std::string said = test::refusal([&] { Scenario::load(file); });
    EXPECT_THAT(said, HasSubstr(sentence)) << sentence << ": " << said;
  }
}

TEST(FirmwareScenario, RefusesARateOfNoMessage) {
  const test::TemporaryFolder folder;
  const auto file = changed(folder, "  drift_m: 1.5\n", "  rates_hz: {ATTITUTE: 10}\n");
  EXPECT_THROW(Scenario::load(file), base::ConfigError);
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
  const Scenario scenario = Scenario::load(copy);
  const std::string config = cas::test::source_dir() + "/config";
  EXPECT_TRUE(std::filesystem::equivalent(scenario.firmware->world.file(),
                                          config + "/worlds/px4_sitl.yaml"));
  EXPECT_TRUE(std::filesystem::equivalent(scenario.firmware->topology.file(),
                                          config + "/topologies/px4_sitl.yaml"));
}

TEST(FirmwareScenario, NamesShippedFilesByTheirWholePathInWhatItWrites) {
  const test::TemporaryFolder folder;
  for (const char* kind : {"worlds", "topologies"}) {
    std::filesystem::create_directories(folder.path() / kind);
    std::filesystem::copy_file(
        std::filesystem::path(cas::test::source_dir() + "/config") / kind / "px4_sitl.yaml",
        folder.path() / kind / "px4_sitl.yaml");
  }
  Scenario scenario;
  scenario.firmware.emplace().world =
      base::ConfigNode::load(folder.path() / "worlds/px4_sitl.yaml");
  scenario.firmware->topology = base::ConfigNode::load(folder.path() / "topologies/px4_sitl.yaml");
  const base::ConfigNode world = composed(folder, {.scenario = scenario});
  const RunPaths paths = RunPaths::of(scenario, folder.path(), folder.path());
  const auto vehicle = world.at("vehicles").items().at(0).require<std::string>("vehicle");
  EXPECT_TRUE(std::filesystem::path(vehicle).is_absolute()) << vehicle;
  EXPECT_TRUE(std::filesystem::exists(vehicle)) << vehicle;
  const auto gains = base::ConfigNode::load(paths.casd_config()).require<std::string>("gains");
  EXPECT_TRUE(std::filesystem::path(gains).is_absolute()) << gains;
  EXPECT_TRUE(std::filesystem::exists(gains)) << gains;
}

TEST(FirmwareScenario, TakesTheFirmwaresPlaceFromTheEnvironment) {
  EXPECT_EQ(with_variables("a ${X}/b ${Y}", {{"X", "/opt"}, {"Y", "1"}}), "a /opt/b 1");
  EXPECT_EQ(with_variables("plain ${", {}), "plain ${");
  EXPECT_EQ(with_variables("${CAS_NO_SUCH_VARIABLE:-iris}!", {}), "iris!");
  EXPECT_EQ(with_variables("${X:-iris}", {{"X", "none_iris"}}), "none_iris");
  EXPECT_THAT(test::refusal([] { with_variables("${CAS_NO_SUCH_VARIABLE}/bin/px4", {}); }),
              HasSubstr("CAS_NO_SUCH_VARIABLE"));
}

/// The topology of the shipped scenario with a station of --gcs.
base::ConfigNode topology_with_station(const test::TemporaryFolder& folder, const char* name) {
  RunRequest request{.scenario = Scenario::load(kScenarios / name)};
  request.station = StationEndpoint::parse("udp_server:14600");
  composed(folder, request);
  return base::ConfigNode::load(
      RunPaths::of(request.scenario, folder.path(), folder.path()).casd_config());
}

TEST(FirmwareScenario, LetsAStationJoinWhereItsTopologyLetsOne) {
  const test::TemporaryFolder folder;
  const auto links = topology_with_station(folder, "px4_sitl.yaml").at("links").items();
  EXPECT_EQ(links.back().require<std::string>("name"), kStationLink);
  EXPECT_EQ(links.back().require<std::string>("type"), "udp_server");
  std::string routes;
  for (const auto& route : topology_with_station(folder, "px4_hitl.yaml").at("routes").items()) {
    routes += route.require<std::string>("from") + ">" + route.require<std::string>("to") + " ";
  }
  EXPECT_EQ(routes, "sim>fcu fcu>sim fcu>gcs gcs>fcu fcu>hils_gcs hils_gcs>fcu ");
}

TEST(FirmwareScenario, HasTheSeedOfItsRunAndNoPaceWhereItFliesAsFastAsItGoes) {
  const test::TemporaryFolder folder;
  RunRequest request{.scenario = Scenario::load(kScenarios / "px4_sitl.yaml"), .seed = 7};
  EXPECT_EQ(composed(folder, request).require<int>("seed"), 7);
  EXPECT_TRUE(composed(folder, request).has("speed"));
  request.clock = Clock::kLockstep;
  EXPECT_FALSE(composed(folder, request).has("speed"));
}

TEST(FirmwareScenario, OfSoftwareTakesNoLimitOnItsStream) {
  const test::TemporaryFolder folder;
  const auto file = changed(folder, "  drift_m: 1.5\n", "  lost: 0\n");
  EXPECT_THAT(test::refusal([&] { Scenario::load(file); }),
              HasSubstr("limits.lost: firmware in software waits"));
}

}  // namespace
}  // namespace cas::hils
