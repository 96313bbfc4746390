// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/scenario.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

using testing::HasSubstr;

const std::string kHead = R"(schema: 1
vehicle: )" + cas::test::source_dir() +
                          R"(/config/vehicles/iris_paper.yaml
home: {lat_deg: 47, lon_deg: 8, alt_m: 488}
rates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}
)";

constexpr const char* kFlight = R"(steps:
  - arm
  - takeoff: {altitude_m: 2.5}
  - hold: {duration_s: 30, measure: true}
  - land
)";

class ScenarioFile : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) const {
    std::ofstream(file_) << text;
    return file_;
  }
  std::string error_of(const std::string& text) const {
    return test::refusal([&] { Scenario::load(write(text)); });
  }
  void TearDown() override { std::filesystem::remove(file_); }

  std::filesystem::path file_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) +
       std::to_string(::getpid()) + ".yaml");
};

TEST_F(ScenarioFile, ABlockOfTheSensorsMakesASecondOne) {
  const std::string fault = "faults:\n  - {at_s: 1, drop: imu_2}\n";
  EXPECT_THAT(error_of(kHead + kFlight + fault), HasSubstr("needs 'plugin: imu_2'"));
  EXPECT_EQ(error_of(kHead + "sensors: {imu_2: {gyro_bias_deg_s: 1}}\n" + kFlight + fault), "");
  const std::string error = error_of(kHead + "sensors: {imu_2: {gyro_bais_deg_s: 1}}\n" + kFlight);
  EXPECT_THAT(error, HasSubstr("gyro_bais_deg_s"));
}

TEST_F(ScenarioFile, RefusesMoreSensorsThanItsLineCarries) {
  const std::string line = "line: {preset: baud_921600}\n";
  EXPECT_EQ(error_of(kHead + line + "sensors: {imu_2: {}}\n" + kFlight), "");
  const std::string error = error_of(kHead + line + "sensors: {imu_2: {}, imu_3: {}}\n" + kFlight);
  EXPECT_THAT(error, HasSubstr("with the further sensors the line carries"));
  EXPECT_THAT(error, HasSubstr("HIL_SENSOR 1500"));
}

TEST_F(ScenarioFile, OdometryCountsOnItsLineByItsRateAndMessage) {
  const std::string line = "line: {preset: baud_921600}\nsensors: {imu_2: {}}\n";
  const auto odometry = [](const char* keys) {
    return "plugins:\n  - {plugin: odometry, " + std::string(keys) + "}\n";
  };
  // Two IMUs take 77 of 88 kB/s; 40 ODOMETRY a second are 9.8, 60 are 14.7, 60 of the other 7.7.
  EXPECT_EQ(error_of(kHead + line + odometry("rate_hz: 40") + kFlight), "");
  EXPECT_THAT(error_of(kHead + line + odometry("rate_hz: 60") + kFlight),
              HasSubstr("HIL_GPS 5 a second, odometry 60"));
  EXPECT_EQ(
      error_of(kHead + line + odometry("rate_hz: 60, message: VISION_POSITION_ESTIMATE") + kFlight),
      "");
  const std::string one =
      error_of(kHead + "line: {preset: baud_921600}\n" + odometry("rate_hz: 250") + kFlight);
  EXPECT_THAT(one, HasSubstr("plugins[0].plugin: with the further sensors"));
}

TEST_F(ScenarioFile, RefusesFaultsOfAFlightOfStockFirmware) {
  for (const char* const effect : {"pause: hilsim", "cut: fcu"}) {
    const std::string error =
        error_of(kHead + kFlight + "faults:\n  - {at_s: 1, for_s: 1, " + effect + "}\n");
    EXPECT_THAT(error, HasSubstr("is a fault of a flight of stock firmware"));
  }
}

TEST_F(ScenarioFile, RefusesAFaultThatAsksForAnUnknownStep) {
  for (const char* const effect : {"for_s: 1, drop: gps", "for_s: 1, unplug: fcu"}) {
    const std::string error =
        error_of(kHead + kFlight + "faults:\n  - {name: x, when: phase == hodl, " + effect + "}\n");
    EXPECT_THAT(error, HasSubstr(".yaml:11"));
    EXPECT_THAT(error,
                HasSubstr("faults[0].when: the scenario has no step 'hodl'; did you mean 'hold'?"));
  }
}

TEST_F(ScenarioFile, RefusesAMissionOfOurController) {
  const std::string error = error_of(kHead + R"(steps:
  - arm
  - mission: {items: [takeoff: {up_m: 3}, rtl]}
)");
  EXPECT_THAT(error, HasSubstr("no hold is measured"));
  const std::string whole = error_of(kHead + R"(steps:
  - arm
  - mission: {items: [takeoff: {up_m: 3}]}
  - hold: {duration_s: 5, measure: true}
  - rtl
)");
  EXPECT_THAT(whole, HasSubstr(".yaml:7: steps[1].mission: only a scenario of stock firmware"));
}

TEST_F(ScenarioFile, SticksAndTheirLossNeedSomethingThatSendsThem) {
  std::string steps = kFlight;
  steps.insert(steps.find("  - land"), "  - sticks: {pitch: 0.5, duration_s: 2}\n");
  EXPECT_THAT(error_of(kHead + steps), HasSubstr("sticks: needs `ground_station: true`"));
  const std::string lost =
      kHead + std::string(kFlight) + "faults: [{at_s: 5, for_s: 1, silence: sticks}]\n";
  EXPECT_THAT(error_of(lost), HasSubstr("faults[0].silence: no sticks can be lost"));
}

TEST_F(ScenarioFile, RefusesARebootOfOurController) {
  const std::string error = error_of(kHead + std::string(kFlight) + "  - disarm\n  - reboot\n");
  EXPECT_THAT(error,
              HasSubstr(": only a scenario of stock firmware (key firmware) has a step reboot"));
}

TEST_F(ScenarioFile, RefusesACircleOfOurController) {
  const std::string error = error_of(kHead + R"(steps:
  - arm
  - takeoff: {altitude_m: 3}
  - loiter: {radius_m: 20, up_m: 3}
  - hold: {duration_s: 5, measure: true}
  - land
)");
  EXPECT_THAT(error, HasSubstr("steps[2].loiter: only a scenario of stock firmware"));
}

TEST_F(ScenarioFile, ReadsStepsInOrder) {
  const Scenario scenario = Scenario::load(write(std::string(kHead) + kFlight));
  ASSERT_EQ(scenario.steps.size(), 4U);
  EXPECT_EQ(scenario.steps[0].kind, StepKind::kArm);
  EXPECT_DOUBLE_EQ(scenario.steps[1].altitude_m, 2.5);
  EXPECT_EQ(scenario.steps[2].duration, std::chrono::seconds(30));
  EXPECT_TRUE(scenario.steps[2].measure);
}

TEST_F(ScenarioFile, RefusesMoreControlsThanSensorsAndStepsWithoutTheirValues) {
  std::string head = kHead;
  head.replace(head.find("sensor_hz: 500"), 14, "sensor_hz: 333");
  EXPECT_THAT(error_of(head + kFlight),
              HasSubstr(": rates.controls_hz: controls answer HIL_SENSOR"));
  std::string flight = kFlight;
  flight.replace(flight.find("takeoff: {altitude_m: 2.5}"), 26, "takeoff");
  EXPECT_THAT(error_of(kHead + flight),
              HasSubstr("steps[1]: needs a map of its values: the step alone: key 'altitude_m' is "
                        "missing"));
}

TEST_F(ScenarioFile, RefusesKeysOfSimulatorAndControllerWithItsOwnLine) {
  const std::pair<std::string, const char*> cases[] = {
      {"line: {packet_los: 0.1}", "line.packet_los: unknown key; did you mean 'packet_loss'?"},
      {"line: {packet_loss: 3}", "line.packet_loss: 3 must lie in [0, 1]"},
      {"line: {preset: nope}", "line.preset: line preset 'nope' is unknown"},
      {"line: [1]", "line: expected a map"},
      {"controller: {stam: 1}", "controller.stam: unknown key; did you mean 'stamp'?"},
      {"controller: {stamp: 1}", "controller.stamp: must be message or arrival"},
      {"controller: {params: {MPC_XY_VELP_ACC: 1}}",
       "controller.params.MPC_XY_VELP_ACC: there is no parameter MPC_XY_VELP_ACC; did you mean "
       "'MPC_XY_VEL_P_ACC'?"},
      {"controller: {params: {MPC_XY_P: 9999}}", "controller.params.MPC_XY_P: is out of range"},
      {"controller: {sensors: {gps: {delay_s: -4}}}",
       "controller.sensors.gps.delay_s: -4 must lie in [0, 10]"},
      {"controller: [1]", "controller: expected a map"},
      {"controller: {seed: 7}",
       "controller.seed: hils sets this key: its value is the scenario's 'seed', or --seed"},
      {"controller: {control_rate_hz: 100}",
       "controller.control_rate_hz: hils sets this key: its value is the scenario's "
       "'rates.controls_hz'"},
      {"controller: {line: {preset: usb}}",
       "controller.line: hils sets this key: its value is the scenario's 'line'"},
      {"sensors: {imu: {rate: 3}}", "sensors.imu.rate: unknown key; did you mean 'rate_hz'?"},
      {"sensors: {gps: {delay_s: -4}}", "sensors.gps.delay_s: -4 must lie in [0, 10]"},
      {"sensors: {magnetometer: {rate_hz: 3333}}",
       "sensors.magnetometer.rate_hz: exceeds the simulation's own rate of 1000"},
      {"sensors: {barometer: {noise: 1}}", "sensors.barometer.noise: unknown key"},
      {"sensors: {barometer: {qnh_hpa: 1003}}",
       "sensors.barometer.qnh_hpa: is no longer a key: the air of the day is `weather`"},
      {"sensors: {radar: {rate_hz: 3}}", "sensors.radar: the vehicle has no plugin 'radar'"},
      {"sensors: {imu: {rate_hz: 100}}",
       "sensors.imu.rate_hz: hils sets this key: its value is the scenario's 'rates.sensor_hz'"},
      {"plugins: [{plugin: imu}]",
       "plugins[0].plugin: each vehicle has plugin imu already; its keys are those of 'sensors: "
       "{imu: ...}'"}};
  for (const auto& [keys, sentence] : cases) {
    const std::string said = error_of(kHead + keys + "\n" + kFlight);
    EXPECT_EQ(said.find(file_.string() + ":5: " + sentence), 0U) << said;
  }
}

TEST_F(ScenarioFile, RefusesRatesBeyondTheSimulatorsStepsAndTheControllers) {
  std::string head = kHead;
  head.replace(head.find("sensor_hz: 500"), 14, "sensor_hz: 2000");
  EXPECT_EQ(error_of(head + kFlight),
            file_.string() +
                ":4: rates.sensor_hz: exceeds the simulation's own rate of 1000 Hz (step_us)");
  EXPECT_EQ(error_of(head + "step_us: 500\n" + kFlight), "");
  head.replace(head.find("controls_hz: 400"), 16, "controls_hz: 1500");
  EXPECT_EQ(error_of(head + "step_us: 500\n" + kFlight),
            file_.string() + ":4: rates.controls_hz: 1500 must lie in [50, 1000]");
}

TEST_F(ScenarioFile, TakesLimitsOnlyWhereTheyAreGiven) {
  const Scenario scenario =
      Scenario::load(write(std::string(kHead) + kFlight + "limits: {lost: 0, rms: {x_m: 0.25}}\n"));
  EXPECT_EQ(scenario.limits.lost, 0U);
  EXPECT_FALSE(scenario.limits.rate_error_pct);
  EXPECT_EQ(scenario.limits.figures, (FigureLimits{{"rms_x_m", 0.25}}));
}

TEST_F(ScenarioFile, TakesALimitOnEachFigureThatIsBetterUpOrDown) {
  const std::string flight = std::string(kHead) + kFlight;
  const Scenario scenario = Scenario::load(
      write(flight + "limits: {gps_lost: 3, real_time_factor: 0.5, sensor_uplink_p90_us: 900,\n"
                     "  rms_estimate: {z_m: 1}, rotor_activity_rad_s2: 90}\n"));
  EXPECT_EQ(scenario.limits.figures, (FigureLimits{{"gps_lost", 3},
                                                   {"real_time_factor", 0.5},
                                                   {"sensor_uplink_p90_us", 900},
                                                   {"rms_estimate_z_m", 1},
                                                   {"rotor_activity_rad_s2", 90}}));
  const auto error = [&](const std::string& limits) {
    return error_of(flight + "limits: {" + limits + "}\n");
  };
  EXPECT_THAT(error("wall_s: 3"), HasSubstr("limits.wall_s: this figure is not better up or down"));
  EXPECT_THAT(error("gps_lost: -1"), HasSubstr("limits.gps_lost"));
  EXPECT_THAT(error("rms: {w_m: 1}"), HasSubstr("w_m"));
  EXPECT_THAT(error("rms_w_m: 1"), HasSubstr("rms_w_m"));
}

constexpr const char* kHeadWithoutVehicle = R"(schema: 1
home: {lat_deg: 47, lon_deg: 8, alt_m: 488}
rates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}
)";

TEST_F(ScenarioFile, FindsAShippedVehicleFromAFolderOfOnesOwn) {
  for (const char* vehicle : {"vehicles/iris_paper.yaml", "../vehicles/iris_paper.yaml"}) {
    const Scenario scenario = Scenario::load(
        write(std::string(kHeadWithoutVehicle) + "vehicle: " + vehicle + "\n" + kFlight));
    EXPECT_TRUE(
        std::filesystem::equivalent(scenario.vehicles.at(0).vehicle,
                                    cas::test::source_dir() + "/config/vehicles/iris_paper.yaml"));
  }
}

TEST_F(ScenarioFile, SaysWhereAVehicleWasSearched) {
  const std::string error =
      error_of(std::string(kHeadWithoutVehicle) + "vehicle: vehicles/no_iris.yaml\n" + kFlight);
  EXPECT_EQ(error.rfind(file_.string() + ":4: vehicle: there is no file", 0), 0U) << error;
  EXPECT_THAT(error, HasSubstr("looked in"));
}

struct BadScenario {
  const char* name;
  const char* rest;      ///< after the head
  const char* sentence;  ///< part of the error
};

class BadScenarioFile : public ScenarioFile, public testing::WithParamInterface<BadScenario> {
 protected:
  BadScenarioFile() {
    file_ = std::filesystem::path(testing::TempDir()) /
            (std::string(GetParam().name) + std::to_string(::getpid()) + ".yaml");
  }
};

TEST_P(BadScenarioFile, IsRefusedWithFileLineAndReason) {
  const std::string error = error_of(std::string(kHead) + GetParam().rest);
  EXPECT_THAT(error, HasSubstr(GetParam().sentence));
  EXPECT_THAT(error, HasSubstr(file_.string() + ":"));
}

INSTANTIATE_TEST_SUITE_P(
    All, BadScenarioFile,
    testing::Values(
        BadScenario{"YearBeforeTheFieldModel",
                    "decimal_year: 2015\nsteps: [arm, {hold: {duration_s: 1, measure: true}}]\n",
                    "decimal_year: 2015 must lie in [2025, 2030]"},
        BadScenario{"UnknownStep", "steps: [arm, loop]\n", "there is no step 'loop'"},
        BadScenario{
            "UnknownIncident",
            "allow: [crsh]\nsteps: [arm, {takeoff: {altitude_m: 2}}, {hold: {duration_s: 1, "
            "measure: true}}, land]\n",
            "'crsh' is no incident; there are ground, crash, attitude, flyaway and strike"},
        BadScenario{"TakeoffUnarmed", "steps: [{takeoff: {altitude_m: 2}}]\n", "needs an arm step"},
        BadScenario{"EndsInTheAir",
                    "steps: [arm, {takeoff: {altitude_m: 2}}, {hold: {duration_s: 1, measure: "
                    "true}}]\n",
                    "ends in the air"},
        BadScenario{"NothingMeasured", "steps: [arm, {takeoff: {altitude_m: 2}}, land]\n",
                    "no hold is measured"},
        BadScenario{"MisspeltMeasure",
                    "steps: [arm, {takeoff: {altitude_m: 2}}, {hold: {duration_s: 1, messure: "
                    "true}}, land]\n",
                    "did you mean 'measure'"},
        BadScenario{"DisarmInTheAir", "steps: [arm, {takeoff: {altitude_m: 2}}, disarm]\n",
                    "would drop the vehicle"},
        BadScenario{"TwoKeysInAStep", "steps: [{arm: {}, land: {}}]\n",
                    "exactly one key, and this has: arm, land"},
        BadScenario{"UnknownArchitecture",
                    "architecture: serial\nsteps: [arm, {takeoff: {altitude_m: 2}}, {hold: "
                    "{duration_s: 1, measure: true}}, land]\n",
                    "there is no architecture 'serial'"},
        BadScenario{"UnknownShape",
                    "steps: [arm, {takeoff: {altitude_m: 2}}, {trajectory: {shape: square, size_m: "
                    "1, duration_s: 9, measure: true}}, land]\n",
                    "a circle, a figure_eight or a step"},
        BadScenario{"TrajectoryOnTheGround",
                    "steps: [arm, {trajectory: {shape: step, size_m: 1, duration_s: 9}}]\n",
                    "trajectory needs a takeoff step"},
        BadScenario{
            "UnknownSensorSet",
            "sensors: rtkk\nsteps: [arm, {takeoff: {altitude_m: 2}}, {hold: {duration_s: 1, "
            "measure: true}}, land]\n",
            ":5: sensors: there is no sensor set 'rtkk'; sets are airsim_mpu6000, "},
        BadScenario{"UnknownLoop", "steps: [arm, {setgain: {loop: velocty, p: 1}}]\n",
                    ":5: steps[1].setgain.loop: there is no loop 'velocty'; loops are rollrate, "},
        BadScenario{"GainBelowZero", "steps: [arm, {setgain: {loop: roll, p: -1}}]\n",
                    ":5: steps[1].setgain.p: -1 must lie in [0, 1000]"},
        BadScenario{"GainWithoutEnd", "steps: [arm, {setgain: {loop: rollrate, d: 1e300}}]\n",
                    ":5: steps[1].setgain.d: 1e+300 must lie in [0, 1000]"},
        BadScenario{"ParameterThatNoFloatHolds", "steps: [arm, {setparam: {MPC_XY_P: 1e39}}]\n",
                    ":5: steps[1].setparam.MPC_XY_P: no parameter holds so large a number"},
        BadScenario{"FaultOfARotorThatIsNotThere",
                    "steps: [arm, {takeoff: {altitude_m: 2}}, {hold: {duration_s: 1, measure: "
                    "true}}, land]\nfaults:\n  - {at_s: 5, rotor: {number: 5, stop: true}}\n",
                    ":7: faults[0]: there is no rotor 5; vehicle 'iris_paper' has 4"},
        BadScenario{"ConditionOfANumber", "steps: [arm, {wait_until: {condition: '5'}}]\n",
                    ":5: steps[1].wait_until.condition: in '5': '5' is compared with nothing"},
        BadScenario{"MisspeltLoop", "steps: [arm, {setgain: {loop: velocty, p: 1}}]\n",
                    "; did you mean 'velocity'?"},
        BadScenario{
            "MisspeltStep", "steps: [arm, {takof: {altitude_m: 2}}, land]\n",
            ":5: steps[1]: there is no step 'takof'; steps are arm, takeoff, goto, "
            "hold, trajectory, sticks, setgain, setparam, wait_until, mission, loiter, transition, "
            "breach, rtl, land, disarm, reboot; did you mean 'takeoff'?"},
        BadScenario{
            "MisspeltArchitecture",
            "architecture: tcsa\nsteps: [arm, {takeoff: {altitude_m: 2}}, {hold: {duration_s: "
            "1, measure: true}}, land]\n",
            "; did you mean 'tcas'?"},
        BadScenario{"MisspeltSensorSet",
                    "sensors: airsim_mpu600\nsteps: [arm, {takeoff: {altitude_m: 2}}, {hold: "
                    "{duration_s: 1, measure: true}}, land]\n",
                    "; did you mean 'airsim_mpu6000'?"},
        BadScenario{"GainThatTheLoopLacks", "steps: [arm, {setgain: {loop: roll, i: 1}}]\n",
                    "loop roll has no I gain"},
        BadScenario{"GainInAnotherCase", "steps: [arm, {setgain: {loop: roll, P: 1}}]\n",
                    ":5: steps[1].setgain.P: "},
        BadScenario{"ParameterByNameAndValue",
                    "steps: [arm, {setparam: {name: MPC_XY_P, value: 1}}]\n",
                    ":5: steps[1].setparam.value: a setparam step has each parameter as a key"},
        BadScenario{"GustWithoutWind",
                    "steps: [arm, {takeoff: {altitude_m: 2}}, {hold: {duration_s: 1, measure: "
                    "true}}, land]\nfaults: [{at_s: 1, gust: {amplitude_m_s: [3, 0, 0], length_m: "
                    "20}}]\n",
                    ":6: faults[0]: needs 'plugin: wind'"},
        BadScenario{"StepWithoutItsKeys",
                    "steps: [arm, {takeoff: {altitude_m: 3}}, {goto: {east_m: 1}}, land]\n",
                    ":5: steps[2].goto: keys are missing: 'north_m', 'up_m'"},
        BadScenario{"StepWithoutOneKey",
                    "steps: [arm, {takeoff: {altitude_m: 3}}, {goto: {north_m: 1, eats_m: 1, up_m: "
                    "3}}, land]\n",
                    "steps[2].goto: key 'east_m' is missing; did you mean it by 'eats_m'"},
        BadScenario{"CircleWithoutItsKeys",
                    "steps: [arm, {takeoff: {altitude_m: 3}}, {loiter: {east_m: 1}}, land]\n",
                    ":5: steps[2].loiter: keys are missing: 'up_m', 'radius_m'"},
        BadScenario{"CircleOnTheSpot",
                    "steps: [arm, {takeoff: {altitude_m: 3}}, {loiter: {up_m: 3, radius_m: -2}}, "
                    "land]\n",
                    ":5: steps[2].loiter.radius_m: is at least 5 m"},
        BadScenario{"TransitionToNothing",
                    "steps: [arm, {takeoff: {altitude_m: 3}}, {transition: {to: boat}}, land]\n",
                    ":5: steps[2].transition.to: a VTOL turns into a plane or a multicopter"},
        BadScenario{"WaitForNothing", "steps: [arm, {wait_until: {timeout_s: 3}}]\n",
                    "wait_until needs a condition"},
        BadScenario{
            "WaitForAnUnknownStep",
            "steps: [arm, {takeoff: {altitude_m: 3}}, {wait_until: {condition: altitude > "
            "2 and phase == hodl}}, {hold: {duration_s: 1, measure: true}}, land]\n",
            ":5: steps[2].wait_until.condition: the scenario has no step 'hodl'; did you mean "
            "'hold'?"},
        BadScenario{"UnknownFact", "steps: [arm, {wait_until: {condition: depth > 3}}]\n",
                    "'depth' is no number"},
        BadScenario{"UnknownKeyOfAStep",
                    "steps: [arm, {takeoff: {altitude_m: 2, speed: 3}}, {hold: {duration_s: 1, "
                    "measure: true}}, land]\n",
                    "speed"},
        BadScenario{"ResponseOfNoStep",
                    "steps: [arm, {takeoff: {altitude_m: 2}}, {hold: {duration_s: 1, measure: "
                    "true}}, land]\nlimits: {responses: {after: {rise_s: 1}}}\n",
                    "no 'trajectory: {shape: step}' of that name"},
        BadScenario{"NegativeLimit",
                    "limits: {rate_error_pct: -1}\nsteps: [arm, {takeoff: {altitude_m: 2}}, "
                    "{hold: {duration_s: 1, measure: true}}, land]\n",
                    "rate_error_pct"}),
    [](const auto& test) { return test.param.name; });

TEST_F(ScenarioFile, RefusesUnknownKeys) {
  const std::string error = error_of(std::string(kHead) + kFlight + "limit: {lost: 0}\n");
  EXPECT_THAT(error, HasSubstr("limit"));
}

class ShippedScenario : public testing::TestWithParam<std::filesystem::path> {};

TEST_P(ShippedScenario, Loads) { EXPECT_NO_THROW(Scenario::load(GetParam())); }

std::vector<std::filesystem::path> shipped() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(cas::test::source_dir() + "/config/scenarios")) {
    const bool is_scenario = entry.path().extension() == ".yaml" &&
                             !base::ConfigNode::load(entry.path()).has("firmware");
    if (is_scenario) files.push_back(entry.path());
  }
  return files;
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScenario, testing::ValuesIn(shipped()),
                         [](const auto& test) { return test.param.stem().string(); });

}  // namespace
}  // namespace cas::hils
