// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/key_path.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

constexpr const char* kScenario = R"(
schema: 1
vehicle: parts/quad.yaml
line: {preset: usb}
plugins:
  - {plugin: wind, mean_m_s: 2}
  - {plugin: battery}
steps:
  - takeoff: {altitude_m: 2}
  - hold: {duration_s: 5}
  - hold: {name: calm, duration_s: 30}
limits: {lost: 0}
)";
constexpr const char* kVehicle = R"(
mass_kg: 1.5
urdf: quad.urdf
rotor: {thrust_coefficient: 5.84e-6}
sensors: table1
)";

class KeyPath : public testing::Test {
 protected:
  KeyPath() {
    scenario_ = folder_.write("scenario.yaml", kScenario);
    folder_.write("parts/quad.yaml", kVehicle);
    folder_.write("parts/quad.urdf", "<robot/>");
  }

  base::ConfigNode written(const std::vector<KeyValue>& values) {
    write_scenario(scenario_, values, folder_.path(), folder_ / "out");
    return base::ConfigNode::load(folder_ / "out/scenario.yaml");
  }
  std::string refusal(const std::string& path) {
    return test::refusal([&] { written({{path, "1"}}); });
  }

  test::TemporaryFolder folder_;
  std::filesystem::path scenario_;
};

TEST_F(KeyPath, SetsAndMakesKeys) {
  const base::ConfigNode root =
      written({{"line.packet_loss", "0.1"}, {"controller.params.MPC_XY_P", "1.2"}});
  EXPECT_EQ(root.at("line").require<double>("packet_loss"), 0.1);
  EXPECT_EQ(root.at("line").require<std::string>("preset"), "usb");
  EXPECT_EQ(root.at("controller").at("params").require<double>("MPC_XY_P"), 1.2);
}

TEST_F(KeyPath, FindsEntriesOfListsByPlaceAndByName) {
  const base::ConfigNode root = written({{"plugins[wind].mean_m_s", "7"},
                                         {"plugins[1].capacity", "3"},
                                         {"steps[calm].hold.duration_s", "40"},
                                         {"steps[takeoff].altitude_m", "9"}});
  EXPECT_EQ(root.at("plugins").items()[0].require<double>("mean_m_s"), 7);
  EXPECT_EQ(root.at("plugins").items()[1].require<double>("capacity"), 3);
  EXPECT_EQ(root.at("steps").items()[2].at("hold").require<double>("duration_s"), 40);
  EXPECT_EQ(root.at("steps").items()[1].at("hold").require<double>("duration_s"), 5);
  EXPECT_EQ(root.at("steps").items()[0].at("takeoff").require<double>("altitude_m"), 9);
}

TEST_F(KeyPath, LeadsThroughTheNameOfAFileIntoACopyOfIt) {
  const base::ConfigNode root =
      written({{"vehicle.mass_kg", "2"}, {"vehicle.sensors.imu.rate_hz", "250"}});
  const auto copy = base::ConfigNode::load(folder_ / "out" / root.require<std::string>("vehicle"));
  EXPECT_EQ(copy.require<double>("mass_kg"), 2);
  EXPECT_EQ(copy.require<std::string>("urdf"),
            std::filesystem::weakly_canonical(folder_ / "parts/quad.urdf").string());
  EXPECT_EQ(copy.at("sensors").require<std::string>("preset"), "table1");
  EXPECT_EQ(copy.at("sensors").at("imu").require<double>("rate_hz"), 250);
  EXPECT_EQ(test::TemporaryFolder::read(folder_ / "parts/quad.yaml"), kVehicle);
}

TEST_F(KeyPath, NamesOfFilesStayTheirs) {
  EXPECT_EQ(written({}).require<std::string>("vehicle"),
            std::filesystem::weakly_canonical(folder_ / "parts/quad.yaml").string());
}

TEST_F(KeyPath, NullTakesAKeyAway) {
  EXPECT_FALSE(written({{"limits.lost", "null"}}).at("limits").has("lost"));
}

TEST_F(KeyPath, RefusesWhatLeadsNowhere) {
  EXPECT_NE(refusal("plugins[rain].mean_m_s").find("no entry of the list is called 'rain'"),
            std::string::npos);
  EXPECT_NE(refusal("steps[hold].duration_s").find("2 entries of the list are called 'hold'"),
            std::string::npos);
  EXPECT_NE(refusal("plugins[9].x").find("counted from 0"), std::string::npos);
  EXPECT_NE(refusal("line[0].x").find("'line' is no list"), std::string::npos);
  EXPECT_NE(refusal("faults[0].for_s").find("no 'faults'; give all of it: 'faults=[...]'"),
            std::string::npos);
  EXPECT_THROW(parse_key_path("a[b"), base::ConfigError);
  EXPECT_THROW(parse_key_path(""), base::ConfigError);
}

}  // namespace
}  // namespace cas::hils
