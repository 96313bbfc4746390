// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/composition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "casd/topology/topology.hpp"
#include "tests/support/paths.hpp"
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
    request.fcu_device = device;
    if (!station.empty()) request.station = StationEndpoint::parse(station);
    RunPlaces places = RunPlaces::of(request.scenario, folder_.path(), folder_.path());
    places.ground_station_port = 14550;
    return casd::Topology::parse(
        base::ConfigNode::parse(casd_config(request, places), "casd.yaml"));
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
  EXPECT_EQ(link(one, "gcs").accept.block_systems, (std::vector<std::uint8_t>{1}));
  const casd::Topology two = topology("two_vehicles");
  EXPECT_EQ(link(two, "gcs").accept.block_systems, (std::vector<std::uint8_t>{1, 2}));
}

TEST_P(Composition, GivesAStationThatJoinsALinkBesideTheScenariosOwn) {
  const casd::Topology two = topology("two_vehicles", "", "tcp_server:5761");
  const casd::LinkConfig& joined = link(two, "gcs2");
  EXPECT_EQ(joined.type, casd::LinkType::kTcpServer);
  EXPECT_EQ(joined.local, "127.0.0.1:5761");
  EXPECT_TRUE(joined.accept.ground_station);
  EXPECT_EQ(joined.accept.block_systems, (std::vector<std::uint8_t>{1, 2}));
  std::vector<std::string> partners;
  for (const casd::RouteConfig& route : two.routes) {
    if (route.from == "gcs2") partners.push_back("to " + route.to);
    if (route.to == "gcs2") partners.push_back("from " + route.from);
  }
  EXPECT_EQ(partners, (std::vector<std::string>{"from fcu1", "to fcu1", "from fcu2", "to fcu2"}));
}

TEST_P(Composition, AsksForALockWhereItOffersTheTerminalItself) {
  EXPECT_FALSE(link(topology("hover"), "fcu").unlocked_pty);
  EXPECT_TRUE(link(topology("hover", "/dev/pts/9"), "fcu").unlocked_pty);
}

TEST(CompositionOfAWorld, HandsTheSdfFileOnWithFullPaths) {
  const cas::test::TemporaryFolder folder;
  folder.write("grid.csv", "");
  folder.write("w.sdf", "");
  const auto file = folder.write(
      "s.yaml",
      "schema: 1\nvehicle: " + cas::test::source_dir() +
          "/config/vehicles/iris_paper.yaml\nworld: w.sdf\nmodel_path: [models]\nmissing: "
          "ignore\npose: {x_m: 1, y_m: 2, z_m: 3}\nrates: {sensor_hz: 500, gps_hz: 5, "
          "controls_hz: 400}\nplugins: [{plugin: wind, grid: grid.csv}, {plugin: of_mine, grid: "
          "10}]\nsteps:\n  - arm\n  - "
          "takeoff: {altitude_m: 2}\n  - hold: {duration_s: 1, measure: true}\n  - land\n");
  RunRequest request;
  request.scenario = Scenario::load(file);
  const RunPlaces places = RunPlaces::of(request.scenario, folder.path(), folder.path());
  const base::ConfigNode config =
      base::ConfigNode::parse(simulator_config(request, Transport::kUdp, places), "hilsim.yaml");
  const auto full = [&](const char* name) {
    return std::filesystem::weakly_canonical(folder / name).string();
  };
  EXPECT_EQ(config.require<std::string>("world"), full("w.sdf"));
  EXPECT_EQ(config.require<std::vector<std::string>>("model_path").at(0), full("models"));
  EXPECT_EQ(config.require<std::string>("missing"), "ignore");
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

}  // namespace
}  // namespace cas::hils
