// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/step_figures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace cas::hils {
namespace {

using std::chrono::seconds;

/// A plane that starts at (5, -3, 1) and flies for 40 s about (10, 0, 40) from there, at `radius_m`
/// and a height that is off by `high_m`.
std::vector<PoseSample> circle(double radius_m, double high_m) {
  std::vector<PoseSample> truth{{.pose = {.x_m = 5, .y_m = -3, .z_m = 1}}};
  for (int i = 1; i <= 400; ++i) {
    const double angle = 2 * M_PI * i / 400;
    truth.push_back({.time_us = i * 100'000,
                     .pose = {.x_m = 15 + radius_m * std::cos(angle),
                              .y_m = -3 + radius_m * std::sin(angle),
                              .z_m = 41 + high_m,
                              .yaw_rad = angle}});
  }
  return truth;
}

Stage loiter(double radius_m) {
  Stage stage{.step = {.kind = StepKind::kHold, .measure = true},
              .begin = base::SimTime{},
              .end = base::SimTime(seconds(41)),
              .accepted = {}};
  stage.reference_m = {10, 0, 40};
  stage.circle_m = radius_m;
  return stage;
}

TEST(Circle, ReferenceIsItsNearestPointAndTheRadiusErrorIsOfTheMean) {
  const std::vector<PoseSample> truth = circle(82, 0.5);
  const Stage stage = loiter(80);
  const auto flown = std::span(truth).subspan(1);
  const ReferenceAt reference = circle_reference(stage, truth);
  EXPECT_NEAR(peak_error_m(flown, reference), std::hypot(2, 0.5), 1e-9);
  EXPECT_NEAR(height_error_m(flown, reference), 0.5, 1e-9);
  EXPECT_NEAR(rms_about(flown, reference).yaw_rad, 0, 1e-12);
  EXPECT_NEAR(radius_error_pct(stage, flown, truth.front().pose), 2.5, 1e-9);
}

TEST(Airspeed, LeastIsOfTheSamplesThatHaveOne) {
  std::vector<PoseSample> truth(3);
  EXPECT_FALSE(least_airspeed_m_s(truth));
  truth[1].airspeed_m_s = 14;
  truth[2].airspeed_m_s = 15;
  EXPECT_EQ(least_airspeed_m_s(truth), 14);
}

/// One sample a second: heights, and north at 2 m/s until `still_s`.
std::vector<PoseSample> line(const std::vector<double>& heights, double speed_m_s) {
  std::vector<PoseSample> truth;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    truth.push_back({.time_us = static_cast<std::int64_t>(i) * 1'000'000,
                     .pose = {.x_m = 0.1 * static_cast<double>(i), .z_m = heights[i]},
                     .v_m_s = {speed_m_s, 0, 0}});
  }
  return truth;
}

Stage step(StepKind kind, int begin_s, int end_s) {
  return {.step = {.kind = kind},
          .begin = base::SimTime(seconds(begin_s)),
          .end = base::SimTime(seconds(end_s)),
          .accepted = {}};
}

TEST(Transition, HeightIsTheMostOfAllOfThem) {
  const auto truth = line({40, 40, 40.3, 39.9, 40, 50, 50, 49.2, 50}, 0);
  EXPECT_FALSE(transition_height_m({step(StepKind::kHold, 0, 9)}, truth));
  const auto most = transition_height_m(
      {step(StepKind::kTransition, 1, 4), step(StepKind::kTransition, 6, 9)}, truth);
  ASSERT_TRUE(most);
  EXPECT_NEAR(*most, 0.8, 1e-12);
}

TEST(Landing, ErrorIsOfAVehicleThatHungStill) {
  const std::vector<double> heights{40, 30, 20, 10, 0};
  const std::vector<Stage> stages{step(StepKind::kLand, 0, 5)};
  EXPECT_NEAR(landing_error_m(stages, line(heights, 0)).value(), 0.4, 1e-12);
  EXPECT_FALSE(landing_error_m(stages, line(heights, 15)));
  EXPECT_FALSE(landing_error_m({step(StepKind::kHold, 0, 5)}, line(heights, 0)));
}

TEST(Landing, DistanceFromTheBeaconIsTheCamerasLast) {
  const auto figure = [](const char* plugin, double last) {
    PluginFigure result;
    result.plugin = plugin;
    result.name = "distance from the beacon";
    result.last = last;
    return result;
  };
  const PluginFigure other = figure("wind", 9);
  const PluginFigure off = figure("landing_target", 0.2);
  EXPECT_EQ(beacon_error_m({other, off}), 0.2);
  EXPECT_FALSE(beacon_error_m({other}));
}

TEST(Sticks, WayIsThatOfTheLastOfThem) {
  const auto truth = line({5, 5, 5, 5, 5, 5, 5, 5}, 0.1);
  EXPECT_FALSE(sticks_way_m({step(StepKind::kHold, 0, 8)}, truth));
  const auto way =
      sticks_way_m({step(StepKind::kSticks, 0, 2), step(StepKind::kSticks, 3, 8)}, truth);
  ASSERT_TRUE(way);
  EXPECT_NEAR(*way, 0.4, 1e-12);
}

TEST(Landing, ErrorOfAPlaneIsFromWhereItTookOff) {
  const std::vector<double> heights{0, 30, 20, 10, 0};
  std::vector<Stage> stages{step(StepKind::kLand, 2, 5)};
  stages.front().on_wing = true;
  EXPECT_NEAR(landing_error_m(stages, line(heights, 15)).value(), 0.4, 1e-12);
}

}  // namespace
}  // namespace cas::hils
