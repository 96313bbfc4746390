// SPDX-License-Identifier: BSD-3-Clause
// What the true motion shows of steps that a vehicle reports as done, and its height over terrain.
#include "hils/measure/true_steps.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "hils/measure/terrain_clearance.hpp"

namespace cas::hils {
namespace {

using std::chrono::seconds;

constexpr double kStartUp_m = 7;  // of the place of takeoff, in the axes of the truth

/// Ten samples a second north of (2, -1, 7) at 10 m/s.
/// @param heights_m  over the takeoff, a second apart
std::vector<PoseSample> northward(const std::vector<double>& heights_m) {
  std::vector<PoseSample> truth;
  for (std::size_t i = 0; i + 1 < heights_m.size(); ++i) {
    for (int tenth = 0; tenth < 10; ++tenth) {
      const double along_s = static_cast<double>(i) + 0.1 * tenth;
      const double up_m = heights_m[i] + 0.1 * tenth * (heights_m[i + 1] - heights_m[i]);
      truth.push_back({.time_us = std::llround(along_s * 1e6),
                       .pose = {.x_m = 2 + 10 * along_s, .y_m = -1, .z_m = kStartUp_m + up_m}});
    }
  }
  return truth;
}

/// A mission from time zero on.
std::vector<Stage> mission(const std::vector<MissionPlace>& places, int end_s) {
  Stage takeoff{.step = {.kind = StepKind::kTakeoff}, .begin = {}, .end = {}, .accepted = {}};
  Stage flown{.step = {.kind = StepKind::kMission},
              .begin = {},
              .end = base::SimTime(seconds(end_s)) + std::chrono::milliseconds(50),
              .accepted = {}};
  flown.step.places = places;
  flown.reference_m = places.back().place_m;
  return {takeoff, flown};
}

TEST(TrueSteps, AWaypointMustBePassedAtItsHeight) {
  const auto truth = northward({0, 20, 20, 20, 20, 20, 20});
  EXPECT_TRUE(steps_not_flown(mission({{2, {30, 0, 20}}, {3, {50, 0, 20}}}, 5), truth).empty());
  const auto missing = steps_not_flown(mission({{2, {30, 0, 30}}, {3, {50, 0, 20}}}, 5), truth);
  ASSERT_EQ(missing.size(), 1U);
  EXPECT_EQ(missing[0], "step 'mission' came no nearer than 10.0 m to the place of item 2");
}

TEST(TrueSteps, WaypointsArePassedInTheirOrder) {
  const auto truth = northward({0, 20, 20, 20, 20, 20, 20});
  const auto missing = steps_not_flown(mission({{2, {40, 0, 20}}, {3, {20, 0, 20}}}, 2), truth);
  ASSERT_FALSE(missing.empty());
  EXPECT_NE(missing.back().find("the place of item"), std::string::npos) << missing.back();
}

TEST(TrueSteps, OfAWaypointAboveTerrainThePlaceCounts) {
  const auto truth = northward({0, 20, 45, 60, 45, 20, 20});
  const std::vector<MissionPlace> places{{2, {30, 0, 20}, 0, true}, {3, {50, 0, 20}, 0, true}};
  std::vector<Stage> stages = mission(places, 5);
  stages.back().step.mission.items = {{.command = mavlink::common::MavCmd::kNavReturnToLaunch}};
  EXPECT_TRUE(steps_not_flown(stages, truth).empty());
  const std::vector<MissionPlace> beside{{2, {30, 0, 20}, 0, true}, {3, {50, 9, 20}, 0, true}};
  const auto missing = steps_not_flown(mission(beside, 5), truth);
  ASSERT_FALSE(missing.empty());
  EXPECT_NE(missing.back().find("9.0 m to the place of item 3"), std::string::npos)
      << missing.back();
}

/// A hill to the north, in the axes of the truth.
double hill_m(double north_m, double) { return kStartUp_m + 10 * std::abs(north_m - 2) / 10; }

TEST(TerrainClearance, IsJudgedBetweenTheWaypointsAboveTerrain) {
  const auto truth = northward({0, 39, 49, 48, 62, 71, 99, 99});
  const std::vector<MissionPlace> places{{1, {10, 0, 39}},
                                         {2, {20, 0, 20}, 0, true},
                                         {3, {40, 0, 20}, 0, true},
                                         {4, {50, 0, 20}, 0, true},
                                         {5, {60, 0, 99}}};
  const auto clearance = terrain_clearance(mission(places, 6), truth, hill_m);
  ASSERT_TRUE(clearance);
  EXPECT_NEAR(clearance->least_m, 18, 1e-9) << "at 30 m, and less at the takeoff";
  EXPECT_NEAR(clearance->most_m, 29, 1e-9) << "at 20 m, and more at 60 m";
}

TEST(TerrainClearance, NeedsTwoPassedWaypointsAboveTerrain) {
  const auto truth = northward({0, 40, 49, 48});
  EXPECT_FALSE(terrain_clearance(mission({{1, {10, 0, 40}, 0, true}}, 3), truth, hill_m));
  const std::vector<MissionPlace> far{{1, {10, 0, 40}, 0, true}, {2, {90, 0, 40}, 0, true}};
  EXPECT_FALSE(terrain_clearance(mission(far, 3), truth, hill_m)) << "the second was not passed";
  EXPECT_FALSE(terrain_clearance(mission({{1, {10, 0, 40}}, {2, {20, 0, 49}}}, 3), truth, hill_m));
}

}  // namespace
}  // namespace cas::hils
