// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/figures_so_far.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace cas::hils {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

base::SimTime at(base::Duration since_start) { return base::SimTime(since_start); }

Limits limits() {
  Limits limits;
  limits.lost = 0;
  limits.figures = {{"sensor_to_control_p99_us", 5000}, {"rms_x_m", 0.5}, {"rms_z_m", 0.1}};
  limits.responses["north"] = {{"rise_s", 1.5}};
  return limits;
}

Stage hold_at(double up_m) {
  Stage stage;
  stage.step = {.kind = StepKind::kHold, .measure = true};
  stage.reference_m = {0, 0, up_m};
  return stage;
}

VehicleReport above(double up_m) {
  VehicleReport report{.heard = true, .has_position = true};
  report.p_N = {0, 0, -up_m};
  report.truth = Motion{.p_m = {0.3, 0, up_m}};
  return report;
}

const LimitCheck& check(const std::vector<LimitCheck>& checks, const std::string& what) {
  const auto found = std::ranges::find(checks, what, &LimitCheck::what);
  if (found == checks.end()) throw std::runtime_error("no " + what);
  return *found;
}

TEST(FiguresSoFar, EveryLimitIsThereBeforeItsValueIs) {
  const auto checks = FiguresSoFar().checks(limits());
  EXPECT_EQ(checks.size(), 7U) << "three messages, the loop, a response, two axes";
  for (const LimitCheck& each : checks) {
    EXPECT_FALSE(each.value) << each.what;
    EXPECT_TRUE(each.bound) << each.what;
    EXPECT_TRUE(each.kept) << each.what;
  }
  EXPECT_EQ(check(checks, "rise time of step 'north'").bound, 1.5);
}

TEST(FiguresSoFar, ErrorsCountInTheMeasuredStepEachMomentOnce) {
  FiguresSoFar figures;
  Stage before = hold_at(2);
  before.step.measure = false;
  figures.add(before, at(seconds(1)), above(7));
  figures.add(hold_at(2), at(seconds(2)), above(2.2));
  figures.add(hold_at(2), at(seconds(2)), above(9));  // the same time: a pause
  figures.add(hold_at(2), at(milliseconds(2050)), above(2.2));
  const auto checks = figures.checks(limits());
  const LimitCheck& north = check(checks, "RMS error of the true position, x_m");
  EXPECT_NEAR(north.value.value(), 0.3, 1e-9);
  EXPECT_NEAR(north.margin().value(), 0.2, 1e-9);
  EXPECT_TRUE(north.kept);
  const LimitCheck& up = check(checks, "RMS error of the true position, z_m");
  EXPECT_NEAR(up.value.value(), 0.2, 1e-9);
  EXPECT_FALSE(up.kept);
  EXPECT_FALSE(check(checks, "HIL_SENSOR lost").value) << "known when the ledgers are";
}

TEST(FiguresSoFar, AnEstimateCountsOnceAndWhileItIsFresh) {
  Limits bounds = limits();
  bounds.figures["rms_estimate_z_m"] = 0.5;
  FiguresSoFar figures;
  figures.add(hold_at(2), at(seconds(2)), above(2.2));
  for (int i = 1; i < 10; ++i) {  // the same message is looked at again, then it is old
    VehicleReport later = above(3);
    later.position_age_s = 0.4;
    figures.add(hold_at(2), at(seconds(2) + i * milliseconds(50)), i < 5 ? above(2.2) : later);
  }
  figures.add(hold_at(2), at(seconds(3)), above(2.4));
  const auto checks = figures.checks(bounds);
  EXPECT_NEAR(check(checks, "RMS error of the estimate, z_m").value.value(),
              std::sqrt((0.04 + 0.16) / 2), 1e-9);
}

TEST(FiguresSoFar, BeginsAnewWhenSimulatedTimeGoesBack) {
  FiguresSoFar figures;
  figures.add(hold_at(2), at(seconds(9)), above(4));
  figures.add(hold_at(2), at(seconds(3)), above(2.1));
  const auto checks = figures.checks(limits());
  EXPECT_NEAR(check(checks, "RMS error of the true position, z_m").value.value(), 0.1, 1e-9);
}

TEST(ReferenceStage, IsThereFromTheClimbToTheLanding) {
  FlightPlan plan({{.kind = StepKind::kArm},
                   {.kind = StepKind::kTakeoff, .altitude_m = 2},
                   {.kind = StepKind::kLand}});
  VehicleReport vehicle{.heard = true, .on_ground = true, .has_position = true};
  plan.update(at(seconds(0)), vehicle);
  EXPECT_FALSE(reference_stage(plan, at(seconds(0))));
  plan.on_outcome(at(seconds(0)));
  vehicle.armed = true;
  ASSERT_TRUE(plan.update(at(seconds(1)), vehicle));
  plan.on_outcome(at(seconds(1)));
  const auto climb = reference_stage(plan, at(seconds(1)));
  ASSERT_TRUE(climb);
  EXPECT_EQ(climb->reference_m.z(), 2);
  EXPECT_EQ(climb->end, at(seconds(1)));
  vehicle.on_ground = false;
  vehicle.in_air = true;
  vehicle.p_N = {0, 0, -2};
  plan.update(at(seconds(5)), vehicle);
  ASSERT_TRUE(plan.update(at(seconds(7)), vehicle)) << "it lands";
  EXPECT_FALSE(reference_stage(plan, at(seconds(7))));
}

}  // namespace
}  // namespace cas::hils
