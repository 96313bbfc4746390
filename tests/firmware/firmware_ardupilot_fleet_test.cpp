// SPDX-License-Identifier: BSD-3-Clause
// Several instances of stock ArduPilot in one run: the shipped scenario with scripted peers.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>

#include "casd/tlog/tlog_packets.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/firmware/shipped_text.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

namespace mv = mavlink::common;

class ArdupilotFleet : public testing::Test {
 protected:
  /// @param steps  those of the scenario
  std::optional<int> fly(const std::string& steps) {
    const std::string json[2] = {std::to_string(free_port()), std::to_string(free_port())};
    const std::string here = std::to_string(free_port());
    std::string world = with_whole_paths(content(kConfig / "worlds/ardupilot.yaml"));
    const std::size_t at = world.find("  - name: copter0");
    const std::string vehicle = world.substr(at);
    world.resize(at);
    for (int i = 0; i < 2; ++i) {
      std::string own = replaced(vehicle, "copter0", i == 0 ? "left" : "right");
      own = replaced(own, "{yaw_deg: 90}", "{x_m: " + std::to_string(5 * i) + ", yaw_deg: 90}");
      world += replaced(own, "# local: 127.0.0.1:9002", "local: 127.0.0.1:" + json[i] + "  #");
    }
    folder_.write("world.yaml", world);
    std::string topology = with_whole_paths(content(kConfig / "topologies/ardupilot_sitl.yaml"));
    topology = replaced(topology, "type: udp, local: 127.0.0.1:14550",
                        "type: udp_server, local: 127.0.0.1:" + here);
    folder_.write("topology.yaml",
                  replaced(topology, "local: 127.0.0.1:14551", "local: 127.0.0.1:0"));
    const auto scenario =
        folder_.write("scenario.yaml",
                      "schema: 1\nname: copters\nworld: world.yaml\ntopology: topology.yaml\n"
                      "not_hil: true\n" +
                          steps + "firmware: {command: ['" + binary_dir() +
                          "/tests/scripted_firmware', ardupilot, '" + json[0] + "," + json[1] +
                          "', '" + here + "', plain, -i, '${CAS_INSTANCE}']}\n");
    hils_.emplace(std::vector<std::string>{binary_dir() + "/bin/hils", "run", scenario.string(),
                                           "--out", folder_ / "out"});
    return hils_->wait_exit(std::chrono::minutes(3));
  }

  nlohmann::json summary() const {
    return nlohmann::json::parse(content(folder_.path() / "out/summary.json"));
  }

  TemporaryFolder folder_;
  std::optional<ChildProcess> hils_;
};

TEST_F(ArdupilotFleet, FliesItsStepsTogetherAndIsJudgedOneByOne) {
  const std::string shipped = content(kConfig / "scenarios/ardupilot_two.yaml");
  ASSERT_EQ(fly(shipped.substr(shipped.find("steps:"))), 0) << hils_->output();
  const nlohmann::json vehicles = summary().at("vehicles");
  ASSERT_EQ(vehicles.size(), 2U);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(vehicles.at(i).at("name"), i == 0 ? "left" : "right");
    EXPECT_EQ(vehicles.at(i).at("system"), i + 1);
    EXPECT_TRUE(vehicles.at(i).at("passed").get<bool>());
    EXPECT_EQ(vehicles.at(i).at("stages").size(), 5U);
  }
  std::set<int> taken_off;
  casd::for_each_tlog_packet(folder_.path() / "out/flight.tlog", mv::table(),
                             [&](std::uint64_t, const mav::PacketView& packet) {
                               const auto command = mav::decode<mv::CommandLong>(packet);
                               if (command && command->command == mv::MavCmd::kNavTakeoff) {
                                 taken_off.insert(command->target_system);
                               }
                             });
  EXPECT_EQ(taken_off, (std::set<int>{1, 2}));
}

TEST_F(ArdupilotFleet, SendsOneOfThemElsewhere) {
  ASSERT_EQ(fly(R"(steps:
  - arm: {timeout_s: 120}
  - takeoff: {altitude_m: 3, timeout_s: 60}
  - hold: {duration_s: 1, measure: true}
  - goto: {vehicle: right, north_m: 3, east_m: 4, up_m: 3, timeout_s: 60}
  - land: {timeout_s: 60}
  - disarm: {timeout_s: 30}
)"),
            0)
      << hils_->output();
  const auto lands_at = [&](const char* name) {
    std::string last;
    std::ifstream truth(folder_.path() / (std::string("out/truth_") + name + ".csv"));
    for (std::string line; std::getline(truth, line);) last = line;
    std::array<double, 3> place{};
    std::stringstream fields(last);
    std::string field;
    std::getline(fields, field, ',');  // time
    for (double& value : place) {
      std::getline(fields, field, ',');
      value = std::atof(field.c_str());
    }
    return place;
  };
  const auto left = lands_at("left");
  const auto right = lands_at("right");
  EXPECT_NEAR(std::hypot(right[0] - left[0], right[1] - left[1]), std::hypot(9, 3), 2)
      << "5 m east of the other at the start, and 3 m north and 4 m east of there";
}

}  // namespace
}  // namespace cas::test
