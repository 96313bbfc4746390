// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/row_result.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "hils/measure/figure_table.hpp"

namespace cas::hils {
namespace {

Scenario jump() {
  Scenario scenario;
  scenario.vehicles.resize(1);
  scenario.steps.resize(1);
  scenario.steps.front().kind = StepKind::kTrajectory;
  scenario.steps.front().name = "jump";
  scenario.steps.front().trajectory.shape = fcu::PatternShape::kSteps;
  return scenario;
}

double figure(const Scenario& scenario, const RowResult& row, const std::string& name) {
  const std::vector<std::string> names = figure_names(scenario);
  EXPECT_EQ(row.figures.size(), names.size());
  EXPECT_EQ(std::ranges::count(names, name), 1) << name;
  return row.figures.at(static_cast<std::size_t>(std::ranges::find(names, name) - names.begin()));
}

TEST(RowResult, HasEachFigureOfTheTableUnderItsKey) {
  const Scenario scenario = jump();
  RunResult run;
  run.verdict.valid = true;
  Measurement& figures = run.vehicles.emplace_back().figures;
  figures.simulated_s = 40;
  figures.rates.gps.lost = 7;
  figures.age_by_stamp = {.count = 3, .p90 = 900};
  figures.peak_error_m = 0.75;
  figures.responses = {{.name = "jump", .size = 2, .rise_s = 1.5, .settling_s = std::nullopt}};
  const RowResult row = row_of(scenario, run);
  EXPECT_EQ(row.figures[kUpFigure], 1);
  EXPECT_EQ(row.figures[kSimulatedFigure], 40);
  EXPECT_EQ(figure(scenario, row, "gps_lost"), 7);
  EXPECT_EQ(figure(scenario, row, "age_by_stamp_p90_us"), 900);
  EXPECT_EQ(figure(scenario, row, "peak_error_m"), 0.75);
  EXPECT_EQ(figure(scenario, row, "jump_rise_s"), 1.5);
  EXPECT_TRUE(std::isnan(figure(scenario, row, "jump_settling_s")));
  EXPECT_TRUE(std::isnan(figure(scenario, row, "rms_x_m"))) << "it was not measured";
}

TEST(RowResult, NamesTheStepThatWasNotDone) {
  const Scenario scenario = jump();
  RunResult run;
  run.verdict.valid = true;
  Measurement& figures = run.vehicles.emplace_back().figures;
  EXPECT_EQ(row_of(scenario, run).unfinished, "");
  figures.flight_failure = "step 2 (takeoff) was not done within 30 s";
  figures.under_way.emplace().step.kind = StepKind::kTakeoff;
  const RowResult row = row_of(scenario, run);
  EXPECT_EQ(row.unfinished, "takeoff");
  EXPECT_EQ(row.figures[kUpFigure], 0);
}

TEST(RowResult, KeepsTheWarningsOfItsFlightWithoutTheFolderOfTheRow) {
  Scenario scenario = jump();
  scenario.file = "/tmp/work/row_7/scenario.yaml";
  RunResult run;
  run.vehicles.resize(1);
  run.verdict.warnings = {"/tmp/work/row_7/vehicle.yaml:4: hardly\nmeant so"};
  RowResult row = row_of(scenario, run);
  EXPECT_EQ(row.warnings, std::vector<std::string>{"vehicle.yaml:4: hardly meant so"});
  row.row = 7;
  const auto read = parse_journal_line(journal_line(row));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->warnings, row.warnings);
  EXPECT_EQ(warnings_of({*read, RowResult{}}).sentences(),
            std::vector<std::string>{"warning in 1 of 1 flights: vehicle.yaml:4: hardly meant so"});
}

/// The machine's figures differ each time, and rows are the same bytes.
TEST(RowResult, HasNoFigureOfTheMachine) {
  const std::vector<std::string> names = figure_names(jump());
  for (const auto& row : figure_table()) {
    const bool is_there = std::ranges::count(names, row.key) == 1;
    const bool is_repeatable = row.part != Figure<Measurement>::Part::kRun;
    EXPECT_EQ(is_there, is_repeatable || row.key == "simulated_s") << row.key;
  }
}

TEST(RowResult, PutsTheNameOfOneOfSeveralVehiclesInFront) {
  Scenario scenario = jump();
  scenario.vehicles.resize(2);
  scenario.vehicles[0].name = "left";
  scenario.vehicles[1].name = "right";
  const std::vector<std::string> names = figure_names(scenario);
  for (const char* name : {"up", "left.rms_x_m", "right.rms_x_m", "right.jump_rise_s"}) {
    EXPECT_EQ(std::ranges::count(names, name), 1) << name;
  }
}

}  // namespace
}  // namespace cas::hils
