// SPDX-License-Identifier: BSD-3-Clause
// Scenarios with several vehicles.
#include <gtest/gtest.h>

#include <string>

#include "base/error.hpp"
#include "hils/compare/comparison.hpp"
#include "hils/programs/composition.hpp"
#include "hils/programs/lockstep_run.hpp"
#include "hils/scenario/scenario.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

const std::string kVehicle =
    "vehicle: " + cas::test::source_dir() + "/config/vehicles/iris_paper.yaml";
const std::string kFleetHead = R"(schema: 1
home: {lat_deg: 47, lon_deg: 8, alt_m: 488}
rates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}
)";
const std::string kTwo = "vehicles:\n  - {name: left, pose: {x_m: 0, y_m: 0}, " + kVehicle +
                         "}\n  - {name: right, pose: {x_m: 3, y_m: 0, yaw_deg: 0}, " + kVehicle;
const std::string kFleetFlight = R"(steps:
  - arm
  - takeoff: {altitude_m: 2.5}
  - goto: {vehicle: right, north_m: 1, east_m: 0, up_m: 2}
  - hold: {duration_s: 30, measure: true}
  - land
)";

class SeveralVehicles : public testing::Test {
 protected:
  Scenario load(const std::string& text) const {
    return Scenario::load(folder_.write("several.yaml", text));
  }
  std::string error_of(const std::string& text) const {
    return test::refusal([&] { load(text); });
  }
  test::TemporaryFolder folder_;
};

TEST_F(SeveralVehicles, AreNumberedInTheOrderOfTheList) {
  const Scenario scenario = load(kFleetHead + kTwo + "}\n" + kFleetFlight);
  ASSERT_EQ(scenario.vehicles.size(), 2U);
  EXPECT_EQ(scenario.systems(), (std::vector<std::uint8_t>{1, 2}));
  EXPECT_EQ(scenario.names(), (VehicleNames{"left", "right"}));
  EXPECT_DOUBLE_EQ(scenario.vehicles[0].start_yaw_rad(), 0);
  EXPECT_NEAR(scenario.vehicles[1].start_yaw_rad(), M_PI / 2, 1e-12);  // the nose to the east
}

TEST_F(SeveralVehicles, HaveWhatTheyAreGivenBeforeWhatAllHave) {
  const Scenario scenario =
      load(kFleetHead + kTwo + ", sensors: rtk, controller: {params: {CAS_TRJ_SIZE: 2}}, " +
           "limits: {lost: 0}}\nsensors: ideal\ncontroller: {stamp: arrival}\n" +
           "limits: {rate_error_pct: 1}\n" + kFleetFlight);
  EXPECT_EQ(scenario.sensors_of(0).as<std::string>(), "ideal");
  EXPECT_EQ(scenario.sensors_of(1).as<std::string>(), "rtk");
  EXPECT_FALSE(scenario.limits_of(0).lost);
  EXPECT_EQ(scenario.limits_of(1).lost, 0U);
  EXPECT_EQ(scenario.limits_of(1).rate_error_pct, 1);
  const RunRequest request{.scenario = scenario, .out = "unused"};
  const auto left = base::ConfigNode::parse(fcu_config(request, 0));
  const auto right = base::ConfigNode::parse(fcu_config(request, 1));
  EXPECT_EQ(left.require<int>("system_id"), 1);
  EXPECT_EQ(right.require<int>("system_id"), 2);
  EXPECT_EQ(right.require<std::string>("stamp"), "arrival");
  EXPECT_EQ(right.at("params").require<double>("CAS_TRJ_SIZE"), 2);
  EXPECT_FALSE(left.has("params"));
  EXPECT_NE(left.require<std::string>("seed"), right.require<std::string>("seed"));
}

TEST_F(SeveralVehicles, StandByInTheStepsOfOthers) {
  const Scenario scenario = load(kFleetHead + kTwo + "}\n" + kFleetFlight);
  EXPECT_EQ(steps_for(0, scenario.steps)[2].kind, StepKind::kStandBy);
  EXPECT_EQ(steps_for(1, scenario.steps)[2].kind, StepKind::kGoto);
  EXPECT_EQ(phase_of(steps_for(0, scenario.steps)[2]), "goto");
  EXPECT_EQ(steps_for(0, scenario.steps)[3].kind, StepKind::kHold);
}

TEST_F(SeveralVehicles, AreJudgedOnlyByTheResponsesThatTheyFly) {
  const Scenario scenario = load(
      kFleetHead + kTwo + "}\nsteps: [arm, {takeoff: {altitude_m: 2}}, {trajectory: {name: jump, " +
      "vehicle: left, shape: step, size_m: 1, duration_s: 9, measure: true}}, land]\n" +
      "limits: {responses: {jump: {rise_s: 2}}}\n");
  EXPECT_EQ(scenario.limits_of(0).responses.size(), 1U);
  EXPECT_TRUE(scenario.limits_of(1).responses.empty());
}

TEST_F(SeveralVehicles, AreRefusedWhereOneFlies) {
  const Scenario scenario = load(kFleetHead + kTwo + "}\n" + kFleetFlight);
  const RunRequest lockstep{.scenario = scenario, .clock = Clock::kLockstep, .out = folder_.path()};
  EXPECT_THROW(run_in_lockstep(lockstep), base::ConfigError);
  EXPECT_THROW(comparison_scenario(scenario, {}), base::ConfigError);
}

struct BadVehicles {
  const char* name;
  std::string text;  ///< after the head
  const char* sentence;
};

class BadVehiclesFile : public SeveralVehicles, public testing::WithParamInterface<BadVehicles> {};

TEST_P(BadVehiclesFile, IsRefusedWithFileLineKeyAndReason) {
  const std::string error = error_of(kFleetHead + GetParam().text);
  EXPECT_NE(error.find("several.yaml:"), std::string::npos) << error;
  EXPECT_NE(error.find(GetParam().sentence), std::string::npos) << error;
}

INSTANTIATE_TEST_SUITE_P(
    All, BadVehiclesFile,
    testing::Values(
        BadVehicles{"UnknownNameInAStep", kTwo + "}\nsteps: [arm, {land: {vehicle: middle}}]\n",
                    ":7: steps[1].land.vehicle: there is no vehicle 'middle'; vehicles are left, "
                    "right"},
        BadVehicles{"UnknownNameInAFault",
                    kTwo + "}\n" + kFleetFlight + "faults: [{vehicle: both, at_s: 1, drop: gps}]\n",
                    ":13: faults[0].vehicle: there is no vehicle 'both'; vehicles are left, right"},
        BadVehicles{"BothKeys", kTwo + "}\n" + kVehicle + "\n" + kFleetFlight,
                    "vehicles: a scenario has 'vehicle' or 'vehicles', not both"},
        BadVehicles{"AListOfOne",
                    "vehicles:\n  - {name: alone, pose: {x_m: 0, y_m: 0}, " + kVehicle + "}\n" +
                        kFleetFlight,
                    "a list of two or more"},
        BadVehicles{
            "TheSameNameTwice",
            kTwo + "}\n  - {name: left, pose: {x_m: 9, y_m: 0}, " + kVehicle + "}\n" + kFleetFlight,
            "vehicles[2].name: two vehicles have the name 'left'"},
        BadVehicles{
            "ANameForNoFile",
            kTwo + "}\n  - {name: a/b, pose: {x_m: 9, y_m: 0}, " + kVehicle + "}\n" + kFleetFlight,
            "letters, digits and underscores"},
        BadVehicles{"OneOnTopOfTheOther",
                    kTwo + "}\n  - {name: top, pose: {x_m: 3.5, y_m: 0}, " + kVehicle + "}\n" +
                        kFleetFlight,
                    "vehicles[2].pose: stands less than 1 m from 'right'"},
        BadVehicles{"UnknownKey", kTwo + ", weight: 3}\n" + kFleetFlight, "vehicles[1].weight"},
        BadVehicles{"OneLeftInTheAir",
                    kTwo + "}\nsteps: [arm, {takeoff: {altitude_m: 2}}, {hold: {duration_s: 1, " +
                        "measure: true}}, {land: {vehicle: left}}]\n",
                    "right: the flight ends in the air"},
        BadVehicles{"MeasuredOnTheGround",
                    kTwo + "}\nsteps: [arm, {takeoff: {vehicle: left, altitude_m: 2}}, " +
                        "{hold: {duration_s: 1, measure: true}}, {land: {vehicle: left}}]\n",
                    "right: a measured hold needs a takeoff"},
        BadVehicles{"TakeoffOfOneUnarmed",
                    kTwo + "}\nsteps: [{arm: {vehicle: left}}, {takeoff: {altitude_m: 2}}]\n",
                    "right: takeoff needs an arm step"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cas::hils
