// SPDX-License-Identifier: BSD-3-Clause
// Two vehicles through one casd on the virtual clock.
#include <gtest/gtest.h>

#include <string>

#include "hils/measure/run_result.hpp"
#include "hils/report/run_report.hpp"
#include "tests/closed_loop/flight_fixture.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

constexpr std::size_t kLeft = 0;
constexpr std::size_t kRight = 1;

Scenario shipped() {
  return Scenario::load(cas::test::source_dir() + "/config/scenarios/two_vehicles.yaml");
}

/// The shipped scenario with a shorter measured stretch.
Scenario two_vehicles() {
  Scenario scenario = shipped();
  for (FlightStep& step : scenario.steps) {
    if (step.measure) step.duration = std::chrono::seconds(5);
  }
  return scenario;
}

struct Flown {
  RunResult run;
  std::string left_truth;
  std::string right_truth;
  std::string log;
  std::string text;
};

Flown fly(const Scenario& scenario, Architecture architecture = Architecture::kTcas) {
  const cas::test::TemporaryFolder folder;
  const RunRequest request{
      .scenario = scenario, .architecture = architecture, .seed = 1, .out = folder.path()};
  Flown flown;
  flown.run = evaluate(request, run_on_virtual_clock(request));
  flown.left_truth = test::content(folder / "truth_left.csv");
  flown.right_truth = test::content(folder / "truth_right.csv");
  flown.log = test::content(folder / "flight.tlog");
  flown.text = write_text(run_report(flown.run));
  return flown;
}

std::uint64_t lost(const VehicleResult& vehicle) {
  const StreamFigures& rates = vehicle.figures.rates;
  return rates.sensor.lost + rates.gps.lost + rates.controls.lost;
}

std::uint64_t lost_on_the_line(const VehicleResult& vehicle) {
  std::uint64_t sum = 0;
  for (const PathAccount& path : vehicle.figures.paths) {
    const auto found = path.losses.find("on the serial line");
    if (found != path.losses.end()) sum += found->second;
  }
  return sum;
}

/// The rows of a truth.csv up to a moment.
std::string rows_until(const std::string& truth, base::SimTime end) {
  std::size_t at = truth.find('\n') + 1;
  while (at < truth.size() && std::stod(truth.substr(at, 16)) < base::to_seconds(end)) {
    at = truth.find('\n', at) + 1;
  }
  return truth.substr(0, at);
}

TEST(TwoVehicles, PassTheShippedScenarioAndAreTheSameToTheByte) {
  const Flown first = fly(shipped());
  EXPECT_TRUE(first.run.verdict.passed) << first.text;
  const Flown second = fly(shipped());
  EXPECT_FALSE(first.left_truth.empty());
  EXPECT_TRUE(first.left_truth == second.left_truth);
  EXPECT_TRUE(first.right_truth == second.right_truth);
  EXPECT_TRUE(first.log == second.log);
}

TEST(TwoVehicles, DrawNumbersOfTheirOwn) {
  Scenario scenario = two_vehicles();
  scenario.faults = {};
  const Flown flown = fly(scenario);
  const auto& vehicles = flown.run.vehicles;
  EXPECT_NE(vehicles[kLeft].figures.rms->x_m, vehicles[kRight].figures.rms->x_m);
}

TEST(TwoVehicles, LoseNothingByTheCutLineOfTheOther) {
  const Flown cut = fly(two_vehicles());
  const VehicleResult& left = cut.run.vehicles[kLeft];
  const VehicleResult& right = cut.run.vehicles[kRight];
  EXPECT_GT(lost(left), 100U) << cut.text;  // 0.2 s at 905 packets a second, both ways
  EXPECT_EQ(lost_on_the_line(left), lost(left)) << cut.text;
  EXPECT_EQ(lost(right), 0U) << cut.text;
  EXPECT_EQ(left.figures.faults.size(), 1U);
  EXPECT_TRUE(right.figures.faults.empty());

  // Up to the landing, where one waits for the other, nothing that the right one does has changed.
  Scenario whole = two_vehicles();
  whole.faults = {};
  const Flown uncut = fly(whole);
  EXPECT_EQ(lost(uncut.run.vehicles[kLeft]), 0U) << uncut.text;
  ASSERT_TRUE(right.record.hold);
  const base::SimTime end = right.record.hold->end;
  EXPECT_TRUE(rows_until(cut.right_truth, end) == rows_until(uncut.right_truth, end));
  EXPECT_FALSE(rows_until(cut.left_truth, end) == rows_until(uncut.left_truth, end));
}

TEST(TwoVehicles, FlyToPlacesCountedFromTheirOwnHomes) {
  const Flown flown = fly(two_vehicles());
  constexpr double kNear_m = 0.5;
  for (const VehicleResult& vehicle : flown.run.vehicles) {
    ASSERT_TRUE(vehicle.figures.rms) << flown.text;
    EXPECT_LT(vehicle.figures.rms->x_m, kNear_m);
    EXPECT_LT(vehicle.figures.rms->y_m, kNear_m);
  }
  EXPECT_EQ(flown.run.vehicles[kLeft].record.hold->reference_m, Eigen::Vector3d(4, 0, 3));
  EXPECT_EQ(flown.run.vehicles[kRight].record.hold->reference_m, Eigen::Vector3d(0, 2, 5));
}

TEST(TwoVehicles, MayFailByThemselves) {
  Scenario scenario = two_vehicles();
  scenario.faults.vehicle.push_back(
      {.script = base::ConfigNode::parse("{at_s: 20, rotor: {number: 1, stop: true}}"),
       .vehicle = kRight});
  const Flown flown = fly(scenario);
  EXPECT_FALSE(flown.run.verdict.passed) << flown.text;
  EXPECT_TRUE(flown.run.vehicles[kLeft].record.faults.empty());
  EXPECT_FALSE(flown.run.vehicles[kRight].record.faults.empty());
  EXPECT_NE(flown.text.find("- right: the flight was not completed"), std::string::npos)
      << flown.text;
  EXPECT_NE(flown.text.find("- left: the flight was not completed: it ended with that of right"),
            std::string::npos)
      << flown.text;
}

class EveryArchitecture : public testing::TestWithParam<Architecture> {};

TEST_P(EveryArchitecture, KeepsTheAccountsOfTwoVehiclesApart) {
  Scenario scenario = two_vehicles();
  scenario.faults = {};
  // In `ts` the lines share one thread's time: with a look a tick it carries 216 of 500 sensors.
  if (GetParam() == Architecture::kTs) scenario.drain_tick_ms = 0;
  const Flown flown = fly(scenario, GetParam());
  for (const VehicleResult& vehicle : flown.run.vehicles) {
    EXPECT_TRUE(vehicle.verdict.valid) << flown.text;
    EXPECT_FALSE(vehicle.record.flight_failure) << flown.text;
    EXPECT_EQ(vehicle.figures.paths.size(), 3U);
  }
}

INSTANTIATE_TEST_SUITE_P(All, EveryArchitecture, testing::ValuesIn(kArchitectures),
                         [](const auto& test) { return std::string(to_string(test.param)); });

}  // namespace
}  // namespace cas::hils
