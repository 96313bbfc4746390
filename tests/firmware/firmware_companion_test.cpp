// SPDX-License-Identifier: BSD-3-Clause
// Trajectories by setpoints, missions and returns of stock firmware, flown by hils.
#include <nlohmann/json.hpp>

#include "tests/firmware/sitl_flight.hpp"

namespace cas::test {
namespace {

/// A second of PX4's clock, after which it takes setpoints for lost, is a third of one here.
constexpr const char* kThreeTimesRealTime = "\nspeed: 3\n";

class FirmwareCompanion : public SitlFlight {
 protected:
  /// Simulated times at which the vehicle was in a mode of PX4, by the flight log.
  bool was_in(std::uint32_t custom_mode) const {
    bool was = false;
    casd::for_each_tlog_packet(folder_.path() / "out/flight.tlog", mv::table(),
                               [&](std::uint64_t, const mav::PacketView& packet) {
                                 const auto beat = mav::decode<mv::Heartbeat>(packet);
                                 was |= beat && packet.source == kVehicle &&
                                        beat->custom_mode == custom_mode;
                               });
    return was;
  }
};

constexpr std::uint32_t kOffboard = 6U << 16U;
constexpr std::uint32_t kMission = 4U << 16U | 4U << 24U;
constexpr std::uint32_t kReturn = 4U << 16U | 5U << 24U;

constexpr const char* kCircle = R"(  - takeoff: {altitude_m: 3, timeout_s: 200}
  - trajectory: {shape: circle, size_m: 2, speed_m_s: 1, duration_s: 12, measure: true}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
)";

TEST_F(FirmwareCompanion, FliesACircleInOffboardAndIsHeldToIt) {
  pace_ = kThreeTimesRealTime;
  start("obedient", "limits: {rms: {x_m: 0.9, y_m: 0.7, z_m: 0.4}}", kCircle);
  ASSERT_EQ(fly(), 0) << output();
  EXPECT_TRUE(was_in(kOffboard));
  const nlohmann::json figures = summary();
  // 12 s at 50 Hz, and a second before: fewer where the machine is late.
  EXPECT_GT(figures.at("setpoints").at("count").get<int>(), 300) << figures.dump(2);
  EXPECT_LT(figures.at("setpoints").at("longest_gap_s").get<double>(), 1);
  // A vehicle that does not move is 1.4 m off a circle of 2 m, along each axis.
  EXPECT_GT(figures.at("rms").at("x_m").get<double>(), 0);
  EXPECT_TRUE(says("about the reference")) << output();
}

TEST_F(FirmwareCompanion, TellsThatOffboardWasLeftForLostSetpoints) {
  pace_ = kThreeTimesRealTime;
  start("deaf", "", kCircle);
  EXPECT_EQ(fly(), 1) << output();
  EXPECT_TRUE(
      says("(trajectory) was broken off: the vehicle left OFFBOARD for HOLD; it said "
           "'Offboard setpoints lost"))
      << output();
}

TEST_F(FirmwareCompanion, FliesAMissionFromTheGroundAndBack) {
  start("obedient", "", R"(  - mission:
      timeout_s: 200
      items:
        - takeoff: {up_m: 3}
        - waypoint: {north_m: 6, east_m: 0, up_m: 4, hold_s: 1}
        - waypoint: {north_m: 6, east_m: 5, up_m: 4}
  - hold: {duration_s: 2, measure: true}
  - rtl: {timeout_s: 200}
  - disarm: {timeout_s: 50}
)");
  ASSERT_EQ(fly(), 0) << output();
  EXPECT_TRUE(was_in(kMission));
  EXPECT_TRUE(was_in(kReturn));
}

struct Lie {
  const char* name;
  const char* word;
  const char* steps;  ///< with no limit of the scenario that would find it
  const char* sentence;
};

class FirmwareLie : public FirmwareCompanion, public testing::WithParamInterface<Lie> {};

TEST_P(FirmwareLie, IsFoundByTheTrueFlight) {
  const Lie& lie = GetParam();
  pace_ = kThreeTimesRealTime;
  start(lie.word, "", lie.steps);
  EXPECT_EQ(fly(), 1) << output();
  EXPECT_TRUE(says(lie.sentence)) << output();
  EXPECT_NE(content(folder_.path() / "out/junit.xml").find("<failure"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Firmware, FirmwareLie,
    testing::Values(Lie{"AMissionWithoutItsWaypoints", "skips-waypoints", R"(  - mission:
      timeout_s: 200
      items:
        - takeoff: {up_m: 3}
        - waypoint: {north_m: 20, east_m: 0, up_m: 4}
        - waypoint: {north_m: 0, east_m: 5, up_m: 4}
  - hold: {duration_s: 1, measure: true}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
)",
                        "to the place of item 2"},
                    Lie{"ATrajectoryWithoutMotion", "ignores-setpoints", kCircle,
                        "step 'trajectory' moved "},
                    Lie{"ALandingInTheAir", "lands-in-words", R"(  - takeoff: {altitude_m: 3}
  - hold: {duration_s: 2, measure: true}
  - land: {timeout_s: 100}
)",
                        "its rotors turn as in flight"},
                    Lie{"AReturnToSomewhereElse", "returns-in-words",
                        R"(  - takeoff: {altitude_m: 3, timeout_s: 200}
  - goto: {north_m: 20, east_m: 0, up_m: 3, timeout_s: 100}
  - hold: {duration_s: 1, measure: true}
  - rtl: {timeout_s: 200}
  - disarm: {timeout_s: 50}
)",
                        "step 'rtl' ended "}),
    [](const auto& test) { return test.param.name; });

constexpr const char* kPlan = R"({
    "fileType": "Plan", "groundStation": "QGroundControl", "version": 1,
    "geoFence": {"circles": [], "polygons": [], "version": 2},
    "mission": {
        "cruiseSpeed": 15, "firmwareType": 12, "hoverSpeed": 5, "vehicleType": 2, "version": 2,
        "plannedHomePosition": [47.397742, 8.545594, 488],
        "items": [
            {"AMSLAltAboveTerrain": null, "Altitude": 4, "AltitudeMode": 1, "autoContinue": true,
             "command": 16, "doJumpId": 1, "frame": 3,
             "params": [0, 0, 0, null, 47.397796, 8.545594, 4], "type": "SimpleItem"},
            {"autoContinue": true, "command": 20, "doJumpId": 2, "frame": 2,
             "params": [0, 0, 0, 0, 0, 0, 0], "type": "SimpleItem"}
        ]
    },
    "rallyPoints": {"points": [], "version": 2}
})";

TEST_F(FirmwareCompanion, FliesAPlanOfQGroundControlToItsLanding) {
  folder_.write("field.plan", kPlan);
  start("obedient", "", R"(  - takeoff: {altitude_m: 3, timeout_s: 200}
  - hold: {duration_s: 1, measure: true}
  - mission: {file: field.plan, timeout_s: 200}
  - disarm: {timeout_s: 50}
)");
  ASSERT_EQ(fly(), 0) << output();
  EXPECT_TRUE(was_in(kMission));
  EXPECT_TRUE(was_in(kReturn)) << "its last item";
}

TEST_F(FirmwareCompanion, TellsWhyAMissionWasNotTaken) {
  std::string plan = kPlan;
  folder_.write("field.plan", replaced(plan, "\"command\": 16", "\"command\": 82"));
  start("obedient", "", R"(  - takeoff: {altitude_m: 3, timeout_s: 200}
  - hold: {duration_s: 1, measure: true}
  - mission: {file: field.plan, timeout_s: 200}
  - disarm: {timeout_s: 50}
)");
  EXPECT_EQ(fly(), 1) << output();
  EXPECT_TRUE(says("the mission was not taken: the vehicle asked for 1 of 2 items: not supported"))
      << output();
}

/// The scripted ArduCopter, which goes as fast as it is answered.
class ArdupilotCompanion : public testing::Test {
 protected:
  std::optional<int> fly(const std::string& steps, const std::string& more = "") {
    const std::string json = std::to_string(free_port());
    const std::string here = std::to_string(free_port());
    folder_.write(
        "world.yaml",
        with_whole_paths(replaced(content(kConfig / "worlds/ardupilot.yaml"),
                                  "# local: 127.0.0.1:9002", "local: 127.0.0.1:" + json + "  #")));
    folder_.write(
        "topology.yaml",
        with_whole_paths(replaced(replaced(content(kConfig / "topologies/ardupilot_sitl.yaml"),
                                           "local: 127.0.0.1:14550", "local: 127.0.0.1:" + here),
                                  "local: 127.0.0.1:14551", "local: 127.0.0.1:0")));
    const auto scenario = folder_.write(
        "scenario.yaml", R"(schema: 1
name: copter
world: world.yaml
topology: topology.yaml
not_hil: true
steps:
  - arm: {timeout_s: 100}
)" + steps + more + "\nfirmware: {command: ['" +
                             binary_dir() + "/tests/scripted_firmware', ardupilot, '" + json +
                             "', '" + here + "']}\n");
    hils_.emplace(std::vector<std::string>{binary_dir() + "/bin/hils", "run", scenario.string(),
                                           "--out", folder_ / "out"});
    return hils_->wait_exit(kFlightPatience);
  }
  std::string output() const { return hils_->output(); }

  TemporaryFolder folder_;
  std::optional<ChildProcess> hils_;
};

TEST_F(ArdupilotCompanion, FliesAFigureEightInGuided) {
  ASSERT_EQ(fly(R"(  - takeoff: {altitude_m: 3, timeout_s: 200}
  - trajectory: {shape: figure_eight, size_m: 3, speed_m_s: 1, duration_s: 12, measure: true}
  - goto: {north_m: 1, east_m: 1, up_m: 3, timeout_s: 100}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
)",
                "limits: {rms: {x_m: 1, y_m: 0.8, z_m: 0.5}}"),
            0)
      << output();
}

TEST_F(ArdupilotCompanion, FollowsTheSticksInLoiterAndHangsInBrakeThen) {
  ASSERT_EQ(fly(R"(  - takeoff: {altitude_m: 3, timeout_s: 200}
  - sticks: {pitch: 0.5, duration_s: 4}
  - hold: {duration_s: 3, measure: true}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
)",
                "limits: {sticks_way_m: 4, rms: {x_m: 0.5, y_m: 0.3, z_m: 0.3}}"),
            0)
      << output();
}

TEST_F(ArdupilotCompanion, FliesAMissionFromTheGroundInAuto) {
  ASSERT_EQ(fly(R"(  - mission:
      timeout_s: 200
      items:
        - takeoff: {up_m: 3}
        - waypoint: {north_m: 6, east_m: 0, up_m: 4}
  - hold: {duration_s: 2, measure: true}
  - rtl: {timeout_s: 200}
  - disarm: {timeout_s: 50}
)"),
            0)
      << output();
}

}  // namespace
}  // namespace cas::test
