// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/composition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "casd/topology/topology.hpp"
#include "fcu/core/fcu_config.hpp"
#include "hils/programs/composed_parts.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

class Composition : public testing::TestWithParam<Architecture> {
 protected:
  /// The topology of a shipped scenario, with a ground station.
  casd::Topology topology(const char* scenario, const std::string& device = "",
                          const std::string& station = "") const {
    RunRequest request;
    request.scenario =
        Scenario::load(cas::test::source_dir() + "/config/scenarios/" + scenario + ".yaml");
    request.architecture = GetParam();
    if (!device.empty()) request.fcu_devices[0] = {.path = device};
    if (!station.empty()) request.station = StationEndpoint::parse(station);
    RunPaths paths = RunPaths::of(request.scenario, folder_.path(), folder_.path());
    paths.ground_station_port = 14550;
    return casd::Topology::parse(base::ConfigNode::parse(casd_config(request, paths), "casd.yaml"));
  }
  cas::test::TemporaryFolder folder_;
};

const casd::LinkConfig& link(const casd::Topology& topology, const std::string& name) {
  return *std::find_if(topology.links.begin(), topology.links.end(),
                       [&](const casd::LinkConfig& one) { return one.name == name; });
}

TEST_P(Composition, LetsNoGroundStationSpeakForVehicleOrSimulator) {
  const casd::Topology one = topology("hover");
  EXPECT_TRUE(link(one, "gcs").accept.ground_station);
  EXPECT_EQ(link(one, "gcs").accept.block_systems, (std::vector<std::uint8_t>{1, 254}));
  const casd::Topology two = topology("two_vehicles");
  EXPECT_EQ(link(two, "gcs").accept.block_systems, (std::vector<std::uint8_t>{1, 2, 254}));
}

TEST_P(Composition, GivesAStationThatJoinsALinkBesideTheScenariosOwn) {
  const casd::Topology two = topology("two_vehicles", "", "tcp_server:5761");
  const casd::LinkConfig& joined = link(two, kStationLink);
  EXPECT_EQ(joined.type, casd::LinkType::kTcpServer);
  EXPECT_EQ(joined.local, "127.0.0.1:5761");
  EXPECT_TRUE(joined.accept.ground_station);
  EXPECT_EQ(joined.accept.block_systems, (std::vector<std::uint8_t>{1, 2, 254}));
  std::vector<std::string> partners;
  for (const casd::RouteConfig& route : two.routes) {
    if (route.from == kStationLink) partners.push_back("to " + route.to);
    if (route.to == kStationLink) partners.push_back("from " + route.from);
  }
  EXPECT_EQ(partners, (std::vector<std::string>{"from fcu1", "to fcu1", "from fcu2", "to fcu2"}));
}

TEST_P(Composition, AsksForALockWhereItOffersTheTerminalItself) {
  EXPECT_FALSE(link(topology("hover"), "fcu").unlocked_pty);
  EXPECT_TRUE(link(topology("hover", "/dev/pts/9"), "fcu").unlocked_pty);
}

TEST(CompositionOfARecorder, WritesNoSensorFileWhereNobodyKeepsIt) {
  const cas::test::TemporaryFolder folder;
  RunRequest request;
  request.scenario = Scenario::load(cas::test::source_dir() + "/config/scenarios/hover.yaml");
  const RunPaths paths = RunPaths::of(request.scenario, folder.path(), folder.path());
  const auto names_a_folder = [&] {
    return simulator_config(request, Transport::kBus, paths).find("sensor_dir") !=
           std::string::npos;
  };
  EXPECT_TRUE(names_a_folder());
  request.keeps_sensors = false;
  EXPECT_FALSE(names_a_folder());
}

TEST(CompositionOfAStation, LetsItInjectFailuresOnlyWhereItIsSaid) {
  const cas::test::TemporaryFolder folder;
  for (const bool may : {false, true}) {
    RunRequest request{
        .scenario = Scenario::load(cas::test::source_dir() + "/config/scenarios/hover.yaml"),
        .station = StationEndpoint::parse("udp_server:14550")};
    request.station->inject_failures = may;
    const RunPaths paths = RunPaths::of(request.scenario, folder.path(), folder.path());
    const auto topology =
        casd::Topology::parse(base::ConfigNode::parse(casd_config(request, paths), "casd.yaml"));
    EXPECT_EQ(link(topology, kStationLink).inject_failures, may);
    EXPECT_FALSE(link(topology, "fcu").inject_failures);
    const base::ConfigNode simulator =
        base::ConfigNode::parse(simulator_config(request, Transport::kUdp, paths), "hilsim.yaml");
    bool takes_orders = false;
    for (const base::ConfigNode& plugin :
         simulator.at("vehicles").items().at(0).at("plugins").items()) {
      takes_orders |=
          plugin.require<std::string>("plugin") == "fault" && plugin.get("by_hand", false);
    }
    EXPECT_EQ(takes_orders, may);
  }
}

TEST(CompositionOfAWorld, HandsTheSdfFileOnWithFullPaths) {
  const cas::test::TemporaryFolder folder;
  folder.write("grid.csv", "");
  folder.write("w.sdf", "");
  const auto file = folder.write(
      "s.yaml",
      "schema: 1\nvehicle: " + cas::test::source_dir() +
          "/config/vehicles/iris_paper.yaml\n"
          "world: w.sdf\nmodel_path: [models]\nmissing: ignore\ncollada_up_axis: applied\n"
          "weather: {temperature_offset_degc: -5, qnh_hpa: 1003.5, humidity: 0.25}\n"
          "pose: {x_m: 1, y_m: 2, z_m: 3}\n"
          "rates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}\n"
          "plugins: [{plugin: wind, grid: grid.csv}, {plugin: of_mine, grid: 10}]\n"
          "steps:\n  - arm\n  - takeoff: {altitude_m: 2}\n"
          "  - hold: {duration_s: 1, measure: true}\n  - land\n");
  RunRequest request{.scenario = Scenario::load(file)};
  const RunPaths paths = RunPaths::of(request.scenario, folder.path(), folder.path());
  const base::ConfigNode config =
      base::ConfigNode::parse(simulator_config(request, Transport::kUdp, paths), "hilsim.yaml");
  const auto full = [&](const char* name) {
    return std::filesystem::weakly_canonical(folder / name).string();
  };
  EXPECT_EQ(config.require<std::string>("world"), full("w.sdf"));
  const base::ConfigNode weather = config.at("weather");
  EXPECT_EQ(weather.require<double>("temperature_offset_degc"), -5);
  EXPECT_EQ(weather.require<double>("qnh_hpa"), 1003.5);
  EXPECT_EQ(weather.require<double>("humidity"), 0.25);
  EXPECT_FALSE(weather.has("temperature_degc"));
  EXPECT_EQ(config.require<std::vector<std::string>>("model_path").at(0), full("models"));
  EXPECT_EQ(config.require<std::string>("missing"), "ignore");
  EXPECT_EQ(config.require<std::string>("collada_up_axis"), "applied");
  EXPECT_EQ(config.require<double>("speed"), 1) << "not the world's real-time factor";
  EXPECT_FALSE(config.has("home")) << "the world's";
  const base::ConfigNode vehicle = config.at("vehicles").items().at(0);
  EXPECT_EQ(vehicle.at("pose").require<double>("z_m"), 3);
  std::map<std::string, std::string> grids;
  for (const base::ConfigNode& plugin : vehicle.at("plugins").items()) {
    if (const auto grid = plugin.find("grid")) {
      grids[plugin.require<std::string>("plugin")] = grid->as<std::string>();
    }
  }
  EXPECT_EQ(grids,
            (std::map<std::string, std::string>{{"wind", full("grid.csv")}, {"of_mine", "10"}}));
}

INSTANTIATE_TEST_SUITE_P(Of, Composition, testing::Values(Architecture::kTcas, Architecture::kTs));

/// Errors of a reader of a generated file whose value came from the user.
class ErrorsOfGeneratedFiles : public testing::Test {
 protected:
  RunRequest request(const std::string& more) {
    const auto file = folder_.write("own/mine.yaml",
                                    "schema: 1\nname: mine\nvehicle: vehicles/iris_paper.yaml\n"
                                    "home: {lat_deg: 47, lon_deg: 8, alt_m: 488}\n"
                                    "rates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}\n"
                                    "steps: [arm, {takeoff: {altitude_m: 2}}, {hold: {duration_s: "
                                    "1, measure: true}}, land]\n" +
                                        more);
    RunRequest request{.scenario = Scenario::load(file)};
    return request;
  }
  base::ConfigNode simulator(const RunRequest& request) {
    const RunPaths paths = RunPaths::of(request.scenario, folder_.path(), folder_.path());
    return base::ConfigNode::parse(simulator_config(request, Transport::kBus, paths), "sim.yaml");
  }
  static std::string error(const base::ConfigNode& node) {
    return test::refusal([&] { node.reject_unused(); });
  }
  std::string mine(const std::string& rest) const {
    return (folder_ / "own/mine.yaml").string() + rest;
  }
  cas::test::TemporaryFolder folder_;
};

TEST_F(ErrorsOfGeneratedFiles, NameThePlaceOfAPluginsKeyInTheScenario) {
  const RunRequest own = request(
      "plugins:\n  - plugin: wind\n    mean_m_s: [1, 0, 0]\n  - plugin: rangefinder\n    rate: "
      "20\n");
  const base::ConfigNode plugin = simulator(own).at("vehicles").items()[0].at("plugins").items()[6];
  EXPECT_EQ(plugin.require<std::string>("plugin"), "rangefinder");
  plugin.find("rate_hz");
  EXPECT_EQ(error(plugin), mine(":11: plugins[1].rate: unknown key; did you mean 'rate_hz'?"));
  EXPECT_EQ(test::refusal([&] { plugin.require<double>("max_m"); }),
            mine(":10: plugins[1]: key 'max_m' is missing"));
}

TEST_F(ErrorsOfGeneratedFiles, NameSensorsFaultsControllerAndLineOfTheScenario) {
  const RunRequest own = request(
      "sensors:\n  preset: airsim_mpu6000\n  imu: {position_B_m: [0, 0, 0]}\n"
      "faults:\n  - {at_s: 1, for_s: 1, rotor: {number: 1, stop: true}}\n"
      "controller:\n  params: {MPC_XY_P: 1}\n"
      "line:\n  preset: usb\n");
  const base::ConfigNode vehicle = simulator(own).at("vehicles").items()[0];
  const auto fail = [](const base::ConfigNode& node) {
    return test::refusal([&] { node.fail("is odd"); });
  };
  EXPECT_EQ(fail(vehicle.at("sensors").at("imu").at("position_B_m")),
            mine(":9: sensors.imu.position_B_m: is odd"));
  EXPECT_EQ(fail(vehicle.at("plugins").items()[5].at("faults").items()[0].at("rotor")),
            mine(":11: faults[0].rotor: is odd"));
  const auto fcu = base::ConfigNode::parse(fcu_config(own, 0), "fcu.yaml");
  EXPECT_EQ(fail(fcu.at("params").at("MPC_XY_P")), mine(":13: controller.params.MPC_XY_P: is odd"));
  EXPECT_EQ(fail(fcu.at("sensors").at("imu").at("position_B_m")),
            mine(":9: sensors.imu.position_B_m: is odd"));
  EXPECT_EQ(fail(fcu.at("line").at("preset")), mine(":15: line.preset: is odd"));
  EXPECT_EQ(fail(fcu.at("vehicle")).rfind("fcu.yaml:", 0), 0U) << "hils's own word";
}

TEST(Composition, OfStockFirmwareIsLeftToItsOwnBench) {
  const RunRequest request{
      .scenario = Scenario::load(cas::test::source_dir() + "/config/scenarios/px4_sitl.yaml")};
  const test::TemporaryFolder folder;
  const RunPaths paths = RunPaths::of(request.scenario, folder.path(), folder.path());
  const std::string said = test::refusal([&] { write_configs(request, Transport::kBus, paths); });
  EXPECT_NE(said.find("px4_sitl.yaml: stock firmware flies this scenario"), std::string::npos)
      << said;
}

}  // namespace
}  // namespace cas::hils
