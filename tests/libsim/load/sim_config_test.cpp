// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sim_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/libsim/support/sim_files.hpp"

namespace cas::sim {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

SimConfig parse(const std::string& text) {
  return SimConfig::parse(base::ConfigNode::parse(text, "sim.yaml"));
}

TEST(SimConfig, ReadsEveryKey) {
  const SimConfig config = parse(test::kHead + test::kFlat + R"(
step_us: 4000
speed: 2.5
seed: 77
integrator: ode
weather: {temperature_offset_degc: 15, qnh_hpa: 1003.5, humidity: 0.6}
beacons:
  - {name: pad, x_m: 1, y_m: 2}
  - {name: truck, on: car, x_m: -1, z_m: 1.5}
pacing:
  catch_up_rate: 1.5
  max_lag_ms: 40
  lockstep_timeout_ms: 300
  thread: {fifo_priority: 20, cpus: [1]}
  cpu_dma_latency_us: 50
vehicles:
  - name: a
    vehicle: )" + test::kIris + R"(
    pose: {x_m: 1, y_m: 2, z_m: 3, yaw_deg: 4}
    plugins:
      - {plugin: imu, rate_hz: 250}
)");
  EXPECT_EQ(config.step, 4ms);
  EXPECT_EQ(config.pace.mode, PaceMode::kFreeRun);
  EXPECT_EQ(config.pace.speed, 2.5);
  EXPECT_EQ(config.pace.catch_up_rate, 1.5);
  EXPECT_EQ(config.pace.max_lag, 40ms);
  EXPECT_EQ(config.pace.lockstep_timeout, 300ms);
  EXPECT_EQ(config.pace.thread.fifo_priority, 20);
  EXPECT_EQ(config.pace.cpu_dma_latency_us, 50);
  EXPECT_EQ(config.seed, 77u);
  EXPECT_EQ(config.integrator, Integrator::kOde);
  EXPECT_EQ(config.home->alt_m, 488.0);
  EXPECT_EQ(config.weather,
            (base::Weather{.temperature_offset_degc = 15, .qnh_hpa = 1003.5, .humidity = 0.6}));
  ASSERT_EQ(config.beacons.size(), 2u);
  EXPECT_EQ(config.beacons[0].y_m, 2);
  EXPECT_FALSE(config.beacons[0].z_m);
  EXPECT_EQ(config.beacons[1].on, "car");
  EXPECT_EQ(config.beacons[1].z_m, 1.5);
  ASSERT_EQ(config.vehicles.size(), 1u);
  EXPECT_EQ(config.vehicles[0].pose.yaw_deg, 4);
}

TEST(SimConfig, ASecondSensorHasItsOwnBlockOverThatOfTheFirst) {
  const SimConfig config =
      test::config("  - {name: a, vehicle: " + test::kIris +
                   ", sensors: {imu: {rate_hz: 250}, imu_2: {gyro_bias_deg_s: 1}}"
                   ", plugins: [{plugin: imu}, {plugin: imu, number: 2}]}\n");
  const PluginConfig& second = config.vehicles[0].plugins[1];
  EXPECT_EQ(second.params.require<double>("rate_hz"), 250);
  EXPECT_EQ(second.params.require<double>("gyro_bias_deg_s"), 1);
  EXPECT_FALSE(config.vehicles[0].plugins[0].params.has("gyro_bias_deg_s"));
}

TEST(SimConfig, OwnKeysGoBeforeTheVehiclesPresets) {
  const SimConfig config = test::config(test::vehicle("a", "{}", "[{plugin: imu, rate_hz: 250}]"));
  const base::ConfigNode& params = config.vehicles[0].plugins[0].params;
  EXPECT_EQ(params.require<double>("rate_hz"), 250);
  EXPECT_EQ(params.require<Eigen::Vector3d>("gyro_stddev_deg_s").x(), 0.67);
}

const std::string kNoVehicles = test::kHead + test::kFlat;
const std::string kGood = kNoVehicles + "vehicles:\n" + test::vehicle("a");

TEST(SimConfigError, NamesFileLineAndKey) {
  struct ErrorCase {
    const char* name;
    std::string text;
    const char* message;
  };
  const ErrorCase rows[] = {
      {"NoVehicles", kNoVehicles, "sim.yaml:1: key 'vehicles' is missing"},
      {"EmptyVehicles", kNoVehicles + "vehicles: []\n", "names no vehicle"},
      {"UnknownKey", kGood + "sped: 2\n", "sped: unknown key; did you mean 'speed'?"},
      {"UnknownPace", kGood + "pacing: {}\nintegrator: euler\n",
       "integrator: 'euler' is none of: rk4, ode"},
      {"StepOutOfRange", kGood + "step_us: 50\n", "step_us: 50 must lie in"},
      {"YearBeyondTheFieldModel", std::regex_replace(kGood, std::regex("2026.5"), "2015"),
       "sim.yaml:3: decimal_year: 2015 must lie in [2025, 2030]"},
      {"TooCold", kGood + "weather:\n  temperature_degc: -200\n",
       ": weather.temperature_degc: -200 must lie in [-90, 60]"},
      {"TwoTemperatures", kGood + "weather: {temperature_degc: 20, temperature_offset_degc: 5}\n",
       "weather.temperature_offset_degc: the temperature is given by 'temperature_degc' already"},
      {"PressureInPascal", kGood + "weather: {qnh_hpa: 101325}\n",
       "weather.qnh_hpa: 101325 must lie in [850, 1100]"},
      {"HumidityInPerCent", kGood + "weather: {humidity: 60}\n",
       "weather.humidity: 60 must lie in [0, 1]"},
      {"UpAxis", kGood + "collada_up_axis: apply\n", "'apply' is none of: ignored, applied"},
      {"TwinNames", kGood + test::vehicle("a"), "two vehicles have the name 'a'"},
      {"TwinBeacons", kGood + "beacons: [{name: a}, {name: a}]\n",
       "beacons[1].name: two beacons have the name 'a'"},
      {"SlashInABeaconsName", kGood + "beacons: [{name: a/b}]\n",
       "a beacon's name is not empty and has no '/'"},
      {"BeaconOnAnObstacleWithoutAHeight", kGood + "beacons: [{name: a, on: car}]\n",
       "beacons[0]: needs z_m, in the axes of the obstacle"},
      {"UnknownKeyOfABeacon", kGood + "beacons: [{name: a, x: 1}]\n",
       "beacons[0].x: unknown key; did you mean 'x_m'?"},
      {"SlashInName", kNoVehicles + "vehicles:\n" + test::vehicle("a/b"), "no '/'"},
      {"NoVehicleFile", kNoVehicles + "vehicles:\n  - {name: a, vehicle: none.yaml}\n",
       "none.yaml"},
      {"OtherSchema", "schema: 2\n", "this program reads schema 1"},
      {"NoHome", "schema: 1\ndecimal_year: 2026\n" + test::kFlat, "key 'home' is missing"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    EXPECT_THAT(test::refusal([&] { parse(row.text); }), HasSubstr(row.message));
  }
}

}  // namespace
}  // namespace cas::sim
