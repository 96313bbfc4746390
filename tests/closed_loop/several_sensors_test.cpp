// SPDX-License-Identifier: BSD-3-Clause
// Our controller with three IMUs and two receivers, or odometry, when a sensor fails in flight.
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/measure/vehicle_messages.hpp"
#include "hils/scenario/scenario.hpp"
#include "hils/virtual/virtual_run.hpp"
#include "tests/hils/report/run_text.hpp"
#include "tests/support/paths.hpp"

namespace cas::hils {
namespace {

/// One flight on the virtual clock: its verdict and what the vehicle told.
struct Flight {
  Flight(const Scenario& scenario, const std::string& name) {
    const auto folder = std::filesystem::path(testing::TempDir()) /
                        ("several_" + name + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    const RunRequest request{
        .scenario = scenario, .architecture = Architecture::kDirect, .seed = 1, .out = folder};
    const RunRecord record = run_on_virtual_clock(request).front();
    const Measurement figures = measure(request, record);
    verdict = judge(figures, scenario.limits);
    text = test::run_text(figures, verdict);
    signs = read_vehicle_messages(record).signs;
    if (!record.faults.empty()) {
      fault_begins_s = base::to_seconds(record.faults.front().begin.time_since_epoch());
    }
    std::filesystem::remove_all(folder);
  }

  Verdict verdict;
  std::string text;
  std::vector<VehicleSign> signs;
  double fault_begins_s = 0;
};

/// The hover with more sensors, and a fault in the measured hold.
/// @param further  plugins, each with a comma behind it
Scenario hover_with(const std::string& sensors, const std::string& fault,
                    const std::string& further = {},
                    std::chrono::seconds hold = std::chrono::seconds(15)) {
  Scenario scenario = Scenario::load(cas::test::source_dir() + "/config/scenarios/hover.yaml");
  for (FlightStep& step : scenario.steps) {
    if (step.measure) step.duration = hold;
  }
  scenario.sensors = base::ConfigNode::parse(sensors);
  scenario.line = base::ConfigNode::parse("{preset: ideal}");  // 921,600 baud do not carry them
  const std::string plugins = "[" + further +
                              "{plugin: fault, faults: [{name: broken, when: phase == hold and "
                              "time > 27, " +
                              fault + "}]}]";
  scenario.plugins = base::ConfigNode::parse(plugins).items();
  scenario.limits.rate_error_pct.reset();  // HIL_GPS of a silent receiver
  return scenario;
}

constexpr const char* kThreeAndTwo =
    "{imu_2: {position_B_m: [0.03, 0.02, 0]}, imu_3: {mounting_rpy_deg: [0, 0, 0.5]}, "
    "gps_2: {antenna_B_m: [0.1, 0, 0.05]}}";

struct FailingSensor {
  const char* name;
  const char* fault;
  const char* text;  ///< STATUSTEXT that tells of it
};

class OneOfSeveral : public testing::TestWithParam<FailingSensor> {};

TEST_P(OneOfSeveral, FailsAndTheFlightGoesOn) {
  const Flight flight(hover_with(kThreeAndTwo, GetParam().fault), GetParam().name);
  EXPECT_TRUE(flight.verdict.passed) << flight.text;
  const auto told = std::ranges::find_if(flight.signs, [](const VehicleSign& sign) {
    return sign.what.find(GetParam().text) != std::string::npos;
  });
  ASSERT_NE(told, flight.signs.end());
  EXPECT_GT(told->time_s, flight.fault_begins_s);
  EXPECT_LT(told->time_s, flight.fault_begins_s + 1);
}

INSTANTIATE_TEST_SUITE_P(
    Sensors, OneOfSeveral,
    testing::Values(  // A value that is stuck far from the others disagrees before it has repeated
                      // often enough.
        FailingSensor{"ImuStuck", "freeze: imu", ": flying by IMU 2"},
        FailingSensor{"ImuDead", "drop: imu", "IMU 1 silent: flying by IMU 2"},
        FailingSensor{"GyroBiased", "bias: {sensor: imu, angular_rate_deg_s: [10, 0, 0]}",
                      "IMU 1 disagrees: flying by IMU 2"},
        FailingSensor{"AccelBiased", "bias: {sensor: imu, specific_force_m_s2: [2, 0, 0]}",
                      "IMU 1 disagrees: flying by IMU 2"},
        FailingSensor{"GpsJumps", "bias: {sensor: gps, position_m: [30, 0, 0]}",
                      "GPS 1 disagrees: flying by GPS 2"},
        FailingSensor{"GpsDead", "drop: gps", "GPS 1 silent: flying by GPS 2"}),
    [](const auto& test) { return test.param.name; });

/// The same faults end the flight, or its limits, of a vehicle with one of each: the others are
/// what flies on.
TEST(OneOfOne, AStuckImuEndsTheFlight) {
  const Flight flight(hover_with("{}", "freeze: imu"), "one_imu_stuck");
  EXPECT_FALSE(flight.verdict.passed) << flight.text;
}

std::string odometry_in(const char* frame) {
  return "{plugin: odometry, rate_hz: 30, delay_s: 0.05, position_stddev_m: 0.01, "
         "attitude_stddev_deg: 0.3, velocity_stddev_m_s: 0.05, rate_stddev_deg_s: 0.5, "
         "position_walk_m_per_sqrt_s: 0.005, frame: " +
         std::string(frame) + "}, ";
}

/// So long a hold leads a vehicle without fixes beyond the scenario's limits.
constexpr std::chrono::seconds kUntilItDrifts{60};

TEST(WithoutFixes, OdometryHoldsThePlace) {
  const Flight flight(hover_with("{}", "drop: gps", odometry_in("LOCAL_NED"), kUntilItDrifts),
                      "odometry");
  EXPECT_TRUE(flight.verdict.passed) << flight.text;
}

/// Odometry in a frame of which the vehicle does not know how it is turned is not used.
TEST(WithoutFixes, AVehicleWithoutOdometryLeavesIt) {
  for (const std::string& further : {std::string(), odometry_in("LOCAL_FRD")}) {
    const Flight flight(hover_with("{}", "drop: gps", further, kUntilItDrifts), "blind");
    EXPECT_FALSE(flight.verdict.passed) << flight.text;
  }
}

TEST(SeveralSensors, TheFaultOfOneThatIsNotFlownByIsNoConcernOfTheFlight) {
  const Flight flight(hover_with(kThreeAndTwo, "drop: imu_3"), "third_dead");
  EXPECT_TRUE(flight.verdict.passed) << flight.text;
  EXPECT_TRUE(std::ranges::none_of(flight.signs, [](const VehicleSign& sign) {
    return sign.what.find("flying by") != std::string::npos;
  })) << flight.text;
}

}  // namespace
}  // namespace cas::hils
