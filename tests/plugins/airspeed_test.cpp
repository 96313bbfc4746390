// SPDX-License-Identifier: BSD-3-Clause
// Plugin airspeed: its model, its samples on the wire and in the record, its faults.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "base/angles.hpp"
#include "base/earth/frames.hpp"
#include "plugins/airspeed/airspeed_model.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/recording_port.hpp"
#include "tests/plugins/statistics.hpp"
#include "tests/support/refusal.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;
using test::RecordingPort;
using test::Statistics;
using test::updated;

constexpr double kQuiet_pa = 1e-9;
constexpr const char* kQuietKeys = "{rate_hz: 50, stddev_pa: 1.0e-9}";

base::AirspeedSheet quiet() {
  base::AirspeedSheet params;
  params.rate_hz = 50;
  params.noise.stddev = Vector3d::Constant(kQuiet_pa);
  return params;
}

double reading_pa(const base::AirspeedSheet& params, double speed_m_s, double density_kg_m3) {
  AirspeedModel tube(params, 0.001, 1);
  tube.follow(speed_m_s, density_kg_m3);
  return tube.sample({}).differential_pressure_pa;
}

TEST(Airspeed, ReadsTheDynamicPressureOfTheAirsDensity) {
  EXPECT_NEAR(reading_pa(quiet(), 20, 1.225), 245, 1e-6);
  EXPECT_NEAR(reading_pa(quiet(), 20, 1.0), 200, 1e-6);
  EXPECT_NEAR(reading_pa(quiet(), 0, 1.225), 0, 1e-6);
}

TEST(Airspeed, AirFromBehindReadsNegative) {
  EXPECT_NEAR(reading_pa(quiet(), -20, 1.225), -245, 1e-6);
}

TEST(Airspeed, PositionErrorIsAFractionAndBiasAConstant) {
  base::AirspeedSheet params = quiet();
  params.position_error = 0.1;
  params.bias_pa = -5;
  EXPECT_NEAR(reading_pa(params, 20, 1.225), 1.1 * 245 - 5, 1e-6);
}

TEST(Airspeed, NoiseHasNoMeanAndTheConfiguredDeviation) {
  base::AirspeedSheet params = quiet();
  params.noise.stddev = Vector3d::Constant(2);
  AirspeedModel tube(params, 0.02, 11);
  Statistics error;
  std::set<double> values;
  constexpr int kSamples = 200'000;
  for (int i = 0; i < kSamples; ++i) {
    tube.follow(20, 1.225);
    const double pressure = tube.sample({}).differential_pressure_pa;
    error.add(pressure - 245);
    values.insert(pressure);
  }
  EXPECT_NEAR(error.mean(), 0, 4 * 2 / std::sqrt(kSamples));
  EXPECT_NEAR(error.stddev(), 2, 0.02);
  EXPECT_GT(values.size(), kSamples - 10U) << "samples repeat";
}

TEST(AirspeedLag, StepResponseIsThatOfItsTimeConstantAtAnyStep) {
  struct LagCase {
    const char* name;
    double step_s;
  };
  const LagCase rows[] = {{"OfOneMillisecond", 0.001}, {"OfFour", 0.004}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    base::AirspeedSheet params = quiet();
    params.lag_s = 0.2;
    AirspeedModel tube(params, row.step_s, 1);
    tube.follow(10, 1.2);  // settled at 60 Pa
    EXPECT_NEAR(tube.sample({}).differential_pressure_pa, 60, 1e-6);
    const int steps = static_cast<int>(std::lround(0.2 / row.step_s));
    for (int i = 0; i < steps; ++i) tube.follow(20, 1.2);
    const double after_one_constant = 60 + 180 * (1 - std::exp(-1.0));
    EXPECT_NEAR(tube.sample({}).differential_pressure_pa, after_one_constant, 1e-6);
  }
}

// World axes: east, north, up; yaw 0 is north; body axes: forward, left, up.
TEST(AlongTube, CountsTheAirThatMeetsItsOpening) {
  struct TubeCase {
    const char* name;
    Vector3d v_WB, wind_W, w_WB_B, position_B_m;
    double yaw_rad;
    double speed_m_s;
  };
  const TubeCase rows[] = {
      {"Ahead", {0, 15, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0, 15},
      {"HeadWindAdds", {0, 15, 0}, {0, -5, 0}, {0, 0, 0}, {0, 0, 0}, 0, 20},
      {"TailWindTakesAway", {0, 15, 0}, {0, 5, 0}, {0, 0, 0}, {0, 0, 0}, 0, 10},
      {"SideslipIsNotSeen", {7, 15, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0, 15},
      {"TurnedEast", {7, 15, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, M_PI / 2, 7},
      // On the left wing, of a turn to the left: the wing goes backwards.
      {"OnATurningWing", {0, 15, 0}, {0, 0, 0}, {0, 0, 0.5}, {0, 2, 0}, 0, 14}};
  for (const auto& of : rows) {
    SCOPED_TRACE(of.name);
    BodyState body;
    body.q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0, 0, of.yaw_rad));
    body.v_WB = of.v_WB;
    body.w_WB_B = of.w_WB_B;
    base::AirspeedSheet params;
    params.position_B_m = of.position_B_m;
    EXPECT_NEAR(speed_along_tube(body, of.wind_W, params), of.speed_m_s, 1e-12);
  }
}

TEST(AirspeedPlugin, FlagsItsFieldOfHilSensorWithANewSampleOnly) {
  test::PluginHarness harness(std::chrono::milliseconds(4));
  harness.world.body.v_WB = {0, 20, 0};
  harness.world.body.q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0, 0, 0));
  harness.add("imu", "{rate_hz: 250, gyro_stddev_deg_s: 1, accel_stddev_m_s2: 0.05}");
  harness.add("airspeed", kQuietKeys);
  harness.add("mavlink_interface", "{transport: bus}");
  RecordingPort wire;
  const auto listening =
      harness.bus.subscribe<WirePacket>("iris0/wire_out", [&](const WirePacket& packet) {
        wire.send({packet.bytes.data(), packet.size});
      });
  harness.run(std::chrono::seconds(2));
  ASSERT_EQ(wire.sensors.size(), 500U);
  int flagged = 0;
  for (const auto& sensor : wire.sensors) {
    if ((updated(sensor) & kUpdatedDiffPressure) == 0) continue;
    ++flagged;
    EXPECT_NEAR(sensor.diff_pressure, 2.45, 1e-6);  // hPa
  }
  EXPECT_EQ(flagged, 100);
}

/// Lines of a run's files; the folder is removed.
std::vector<std::string> recorded(bool has_tube, const std::string& file) {
  std::string name = (std::filesystem::temp_directory_path() / "cas_airspeed_XXXXXX").string();
  const std::filesystem::path folder = mkdtemp(name.data());
  {
    test::PluginHarness harness(std::chrono::milliseconds(10), folder);
    harness.world.body.v_WB = {3, 4, 0};
    harness.world.air.wind_W = {0, 4, 0};
    if (has_tube) harness.add("airspeed", kQuietKeys);
    harness.add("recorder", "{file: truth.csv, rate_hz: 100, sensor_dir: sensors, ulog: a.ulg}");
    harness.run(std::chrono::seconds(1));
    harness.finish();
  }
  std::vector<std::string> lines;
  std::ifstream in(folder / file);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  std::filesystem::remove_all(folder);
  return lines;
}

TEST(AirspeedPlugin, PutsTrueAirspeedAndSamplesIntoTheRecord) {
  const auto truth = recorded(true, "truth.csv");
  ASSERT_EQ(truth.size(), 102U);
  EXPECT_TRUE(truth.front().ends_with(",omega4_rad_s,airspeed_m_s")) << truth.front();
  EXPECT_TRUE(truth.back().ends_with(",0,3")) << truth.back();
  EXPECT_EQ(recorded(true, "sensors/airspeed.csv").size(), 51U);
  EXPECT_TRUE(recorded(false, "truth.csv").front().ends_with(",omega4_rad_s"));
  EXPECT_TRUE(recorded(false, "sensors/airspeed.csv").empty());
}

TEST(AirspeedPlugin, TopicsOfTheLogAreThoseOfTheVehicle) {
  const auto has = [](const std::vector<std::string>& log, const char* topic) {
    return std::ranges::any_of(
        log, [&](const auto& line) { return line.find(topic) != std::string::npos; });
  };
  const auto with = recorded(true, "a.ulg");
  EXPECT_TRUE(has(with, "airspeed_groundtruth:"));
  EXPECT_TRUE(has(with, "differential_pressure:"));
  const auto without = recorded(false, "a.ulg");
  EXPECT_FALSE(has(without, "airspeed_groundtruth"));
  EXPECT_FALSE(has(without, "differential_pressure"));
}

/// Readings at 50 Hz of a vehicle at 20 m/s whose tube has a fault from 1 s on.
std::vector<double> with_fault(const std::string& effect) {
  test::PluginHarness harness(std::chrono::milliseconds(20));
  harness.world.body.q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0, 0, 0));
  harness.world.body.v_WB = {0, 20, 0};
  harness.add("airspeed", kQuietKeys);
  harness.add("fault", "{faults: [{at_s: 1, " + effect + "}]}");
  std::vector<double> readings;
  const auto listening = harness.bus.subscribe<AirspeedSample>(
      "iris0/airspeed",
      [&](const AirspeedSample& s) { readings.push_back(s.differential_pressure_pa); });
  harness.run(std::chrono::seconds(1));
  harness.world.body.v_WB = {0, 30, 0};
  harness.run(std::chrono::seconds(1));
  return readings;
}

TEST(AirspeedFault, ABlockedTubeHoldsItsReading) {
  const auto readings = with_fault("freeze: airspeed");
  ASSERT_EQ(readings.size(), 100U);
  EXPECT_EQ(readings.back(), readings[49]);
  EXPECT_NEAR(readings.back(), 245, 1e-6);
}

TEST(AirspeedFault, ALeakTakesAShare) {
  const auto readings = with_fault("scale: {sensor: airspeed, differential_pressure: 0.5}");
  ASSERT_EQ(readings.size(), 100U);
  EXPECT_NEAR(readings.back(), 0.5 * 0.5 * 1.225 * 900, 1e-6);
}

TEST(AirspeedFault, KnowsTheEffectsOfOtherSensors) {
  EXPECT_EQ(with_fault("drop: airspeed").size(), 50U);
  const double truth = 0.5 * 1.225 * 900;
  EXPECT_NEAR(with_fault("bias: {sensor: airspeed, differential_pressure_pa: 30}").back(),
              truth + 30, 1e-6);
  EXPECT_NEAR(with_fault("clip: {sensor: airspeed, differential_pressure_pa: 300}").back(), 300,
              1e-6);
  EXPECT_NEAR(with_fault("drift: {sensor: airspeed, differential_pressure_pa_s: 10}").back(),
              truth + 10, 0.3);
}

TEST(AirspeedKeys, RefusesASilentDeviation) {
  test::PluginHarness harness(std::chrono::milliseconds(4));
  const std::string said =
      test::refusal([&] { harness.add("airspeed", "{rate_hz: 50, stddev_pa: 0}"); });
  EXPECT_NE(said.find("must be above zero"), std::string::npos) << said;
}

}  // namespace
}  // namespace cas::sim
