// SPDX-License-Identifier: BSD-3-Clause
// Fault scripts of a scenario: the flight tells the simulator its phase.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/closed_loop/flight_fixture.hpp"

namespace cas::hils {
namespace {

using test::Flight;

/// The hover with a short hold and these further plugins.
Scenario hover_with(const std::string& plugins) {
  Scenario scenario = test::hover();
  for (FlightStep& step : scenario.steps) {
    if (step.measure) step.duration = std::chrono::seconds(8);
  }
  scenario.plugins = base::ConfigNode::parse(plugins).items();
  scenario.limits = {};
  return scenario;
}

struct Event {
  double time_s;
  std::string what;
};

std::vector<Event> events(const Flight& flight) {
  std::vector<Event> list;
  const auto stats = nlohmann::json::parse(flight.simulator_stats());
  for (const auto& event : stats.at("plugins").at("fault@iris0").at("events")) {
    list.push_back({event.at("time_s"), event.at("fault").get<std::string>() + " " +
                                            event.at("event").get<std::string>()});
  }
  return list;
}

const char* const kDeadRotor =
    "[{plugin: fault, faults: [{name: dead, when: phase == hold, for_s: 60, "
    "rotor: {number: 1, thrust_share: 0}}]}]";

/// A vehicle that hits the ground has failed even without limits; the verdict has time and speed.
TEST(Incident, AVehicleThatFallsHasFailedWithoutAnyLimit) {
  const Flight flight(hover_with(kDeadRotor), 1, "dead_rotor");
  const Verdict& verdict = flight.verdict();
  EXPECT_TRUE(verdict.valid) << flight.text();
  EXPECT_FALSE(verdict.passed) << flight.text();
  EXPECT_NE(flight.text().find("the vehicle hit the ground at "), std::string::npos)
      << flight.text();
  EXPECT_NE(flight.text().find("in step 'hold'"), std::string::npos) << flight.text();
}

TEST(FaultScript, FiresOnThePhasesOfTheFlight) {
  const Flight flight(hover_with("[{plugin: fault, faults: ["
                                 "{name: gone, when: phase == hold, for_s: 0.5, drop: gps},"
                                 "{name: weak, when: phase == land, until: phase == disarm, "
                                 "voltage_share: 0.98},"
                                 "{name: never, when: phase == goto, drop: imu}]}]"),
                      1, "phases");
  EXPECT_TRUE(flight.verdict().passed) << flight.text();
  std::map<StepKind, double> first_begin_s;
  for (const Stage& stage : flight.figures().stages) {
    first_begin_s.emplace(stage.step.kind, base::to_seconds(stage.begin.time_since_epoch()));
  }
  const double hold_s = first_begin_s.at(StepKind::kHold);
  const std::vector<Event> expected{{hold_s, "gone begin"},
                                    {hold_s + 0.5, "gone end"},
                                    {first_begin_s.at(StepKind::kLand), "weak begin"},
                                    {first_begin_s.at(StepKind::kDisarm), "weak end"}};
  const std::vector<Event> seen = events(flight);
  ASSERT_EQ(seen.size(), expected.size()) << flight.simulator_stats();
  constexpr double kStepS = 1e-3;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].what, expected[i].what);
    EXPECT_NEAR(seen[i].time_s, expected[i].time_s, kStepS) << seen[i].what;
  }
}

/// Columns of truth.csv.
enum Column { kTime, kX, kY, kZ, kVx, kVy, kVz, kRoll, kPitch, kYaw, kRollRate, kOmega1 = 13 };

using Row = std::vector<double>;

std::vector<Row> truth_rows(const Flight& flight) {
  std::vector<Row> rows;
  std::istringstream in(flight.truth());
  std::string line;
  std::getline(in, line);  // heading
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    Row& row = rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
  }
  return rows;
}

struct Breakage {
  const char* name;
  const char* fault;
  std::size_t column;  ///< of the truth
  double after_s;      ///< since the fault began
  double at_least;     ///< change against the same flight without it; the sign counts
};

class BrokenVehicle : public testing::TestWithParam<Breakage> {
 protected:
  static void SetUpTestSuite() { whole_ = new Flight(hover_with("[]"), 1, "whole"); }
  static void TearDownTestSuite() {
    delete whole_;
    whole_ = nullptr;
  }
  static inline const Flight* whole_ = nullptr;
};

TEST_P(BrokenVehicle, MovesAsItMust) {
  const Breakage& breakage = GetParam();
  const Flight broken(hover_with("[{plugin: fault, faults: [{when: phase == hold, for_s: 1, " +
                                 std::string(breakage.fault) + "}]}]"),
                      1, breakage.name);
  const std::vector<Event> seen = events(broken);
  ASSERT_FALSE(seen.empty());
  const std::vector<Row> before = truth_rows(*whole_);
  const std::vector<Row> after = truth_rows(broken);
  constexpr double kRowS = 0.01;
  const double begin_s = seen[0].time_s;
  const auto last_whole = static_cast<std::size_t>(begin_s / kRowS);
  const auto looked_at = static_cast<std::size_t>((begin_s + breakage.after_s) / kRowS);
  ASSERT_GT(after.size(), looked_at);
  for (std::size_t i = 0; i <= last_whole; ++i) ASSERT_EQ(before[i], after[i]) << i;
  const double change = after[looked_at][breakage.column] - before[looked_at][breakage.column];
  EXPECT_GT(change / breakage.at_least, 1) << "changed by " << change;
}

INSTANTIATE_TEST_SUITE_P(
    Faults, BrokenVehicle,
    testing::Values(
        // Rotor 1 is front right: without its thrust the nose falls and the right side drops.
        Breakage{"WeakRotorRolls", "rotor: {number: 1, thrust_share: 0.8}", kRoll, 0.1, 0.01},
        Breakage{"WeakRotorPitches", "rotor: {number: 1, thrust_share: 0.8}", kPitch, 0.1, -0.01},
        Breakage{"StoppedRotorStops", "rotor: {number: 1, stop: true}", kOmega1, 0.2, -600},
        Breakage{"StarvedRotorsSink", "voltage_share: 0.9", kZ, 0.3, -0.02},
        Breakage{"HeavyVehicleSinks", "mass_factor: 1.3", kZ, 0.3, -0.02},
        Breakage{"NoseHeavyVehiclePitches", "cg_shift_B_m: [0.02, 0, 0]", kPitch, 0.1, -0.01},
        Breakage{"BiasedGyroTurns", "bias: {sensor: imu, angular_rate_deg_s: [0, 0, 20]}", kYaw,
                 0.9, 0.02}),
    [](const auto& test) { return test.param.name; });

TEST(FaultScript, AGustInTheHoldPushesTheVehicle) {
  const auto flown = [](const std::string& plugins, const std::string& name) {
    return Flight(hover_with(plugins), 1, name).figures().rms->x_m;
  };
  const double calm_m = flown("[{plugin: wind}]", "calm");
  const double pushed_m = flown(
      "[{plugin: wind}, {plugin: fault, faults: [{when: phase == hold and time > 1, gust: "
      "{amplitude_m_s: [8, 0, 0], length_m: 5, hold_s: 10}}]}]",
      "pushed");
  EXPECT_GT(pushed_m, 1.5 * calm_m);
}

}  // namespace
}  // namespace cas::hils
