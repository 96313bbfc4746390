// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/incident.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "hils/measure/struck_object.hpp"

namespace cas::hils {
namespace {

using std::chrono::seconds;

/// Arm, takeoff to 10 m, hold, land: from 0 to 1, 5, 15 and 25 s.
std::vector<Stage> flight() {
  std::vector<Stage> stages;
  const auto add = [&](StepKind kind, int begin, int end) {
    Stage stage;
    stage.step.kind = kind;
    stage.begin = base::SimTime(seconds(begin));
    stage.end = base::SimTime(seconds(end));
    stage.reference_m = {0, 0, kind == StepKind::kArm ? 0.0 : 10.0};
    stages.push_back(stage);
  };
  add(StepKind::kArm, 0, 1);
  add(StepKind::kTakeoff, 1, 5);
  add(StepKind::kHold, 5, 15);
  add(StepKind::kLand, 15, 25);
  return stages;
}

using Path = std::function<void(double t, PoseSample& sample)>;

/// 100 samples a second; at rest the vehicle is at 0.1 m above the ground's zero. Velocities are
/// the differences of the places.
std::vector<Incident> incidents_of(const Path& path, const std::vector<Stage>& stages = flight()) {
  std::vector<PoseSample> truth;
  for (int i = 0; i <= 2500; ++i) {
    PoseSample sample{.time_us = i * 10'000};
    path(0.01 * i, sample);
    sample.pose.z_m += 0.1;
    if (!truth.empty()) {
      const Pose& before = truth.back().pose;
      sample.v_m_s = {(sample.pose.x_m - before.x_m) / 0.01, (sample.pose.y_m - before.y_m) / 0.01,
                      (sample.pose.z_m - before.z_m) / 0.01};
    }
    truth.push_back(sample);
  }
  return find_incidents(stages, truth);
}

/// Up to 10 m by 5 s, down from 15 s on at 1.5 m/s.
void good_height(double t, PoseSample& sample) {
  sample.pose.z_m = t < 1    ? 0
                    : t < 5  ? 2.5 * (t - 1)
                    : t < 15 ? 10
                             : std::max(0.0, 10 - 1.5 * (t - 15));
}

/// Falls from 10 m at 10 s and lies there.
void fall(double t, PoseSample& sample) {
  good_height(t, sample);
  if (t > 10) sample.pose.z_m = std::max(0.0, 10 - 0.5 * 9.81 * (t - 10) * (t - 10));
}

TEST(Incident, AGoodFlightHasNone) { EXPECT_TRUE(incidents_of(good_height).empty()); }

/// 10 m of free fall take 1.43 s and end at 14.0 m/s.
TEST(Incident, AFallIsACrashAndATouchWithNameAndTime) {
  const auto found = incidents_of(fall);
  ASSERT_EQ(found.size(), 2U);
  for (const Incident& incident : found) {
    EXPECT_NEAR(incident.time_s, 11.43, 0.03);
    EXPECT_NE(incident.what.find("in step 'hold'"), std::string::npos) << incident.what;
  }
  const auto crash = found[0].kind == IncidentKind::kCrash ? found[0] : found[1];
  EXPECT_EQ(crash.what.rfind("hit the ground at 1", 0), 0U) << crash.what;
}

/// Between two steps, and after the last one: a step ends on the vehicle's own word.
TEST(Incident, NothingGoesUnseenBetweenStepsAndAfterThem) {
  std::vector<Stage> stages = flight();
  stages[2].end = base::SimTime(seconds(9));  // then it waits for others
  EXPECT_EQ(incidents_of(fall, stages).size(), 2U);

  stages = flight();
  stages[3].end = base::SimTime(seconds(17));  // "on the ground", 7 m above it
  Stage disarm;
  disarm.step.kind = StepKind::kDisarm;
  disarm.begin = stages[3].end;
  disarm.end = base::SimTime(std::chrono::milliseconds(17'100));
  stages.push_back(disarm);
  const auto found = incidents_of(
      [](double t, PoseSample& sample) {
        good_height(t, sample);
        if (t > 17) sample.pose.z_m = std::max(0.0, 7 - 0.5 * 9.81 * (t - 17) * (t - 17));
      },
      stages);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].what.rfind("hit the ground at 11", 0), 0U) << found[0].what;
  EXPECT_NEAR(found[0].time_s, 18.19, 0.03);
}

TEST(Incident, WhatFallsWhenTheRecordEndsIsACrash) {
  const auto found = incidents_of([](double t, PoseSample& sample) {
    good_height(t, sample);
    if (t > 15) sample.pose.z_m = 10;
    if (t > 24) sample.pose.z_m = 10 - 0.5 * 9.81 * (t - 24) * (t - 24);
  });
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, IncidentKind::kCrash);
  EXPECT_EQ(found[0].what.rfind("was still falling at 9.8 m/s", 0), 0U) << found[0].what;
}

/// It meets the ground at 1.5 m/s down and 12 m/s ahead, of which it keeps half.
TEST(Incident, APlaneThatRollsOutHasNotCrashed) {
  const auto touch_down = [](double t, PoseSample& sample) {
    good_height(t, sample);
    const double landing = std::max(0.0, t - 15);  // before it the height alone counts
    sample.pose.x_m = landing < 6.66 ? 12 * landing : 12 * 6.66 + 6 * (landing - 6.66);
  };
  const auto kinds = [&](bool on_wing) {
    std::vector<Stage> stages = flight();
    for (Stage& stage : stages) {
      stage.on_wing = on_wing;
      stage.reference_m = {300, 0, 10};  // it may fly that far
    }
    return incidents_of(touch_down, stages);
  };
  EXPECT_TRUE(kinds(true).empty());
  ASSERT_EQ(kinds(false).size(), 1U);
  EXPECT_EQ(kinds(false)[0].kind, IncidentKind::kCrash);
}

TEST(Incident, ALandingFasterThan3MetresASecondIsACrash) {
  const auto landing = [](double speed) {
    return incidents_of([speed](double t, PoseSample& sample) {
      good_height(t, sample);
      if (t > 15) sample.pose.z_m = std::max(0.0, 10 - speed * (t - 15));
    });
  };
  EXPECT_TRUE(landing(2.9).empty());
  const auto hard = landing(3.1);
  ASSERT_EQ(hard.size(), 1U);
  EXPECT_EQ(hard[0].kind, IncidentKind::kCrash);
}

TEST(Incident, ATouchInTheAirIsOneEvenWhenItIsSoft) {
  const auto found = incidents_of([](double t, PoseSample& sample) {
    good_height(t, sample);
    if (t > 5 && t < 15) sample.pose.z_m = std::abs(t - 10) * 2;  // 2 m/s to the ground and up
  });
  ASSERT_GE(found.size(), 1U);
  EXPECT_EQ(found[0].kind, IncidentKind::kGround);
}

TEST(Incident, AnObstacleIsHitInTheAir) {
  const auto found = incidents_of([](double t, PoseSample& sample) {
    good_height(t, sample);
    if (t > 5 && t < 15) sample.pose.x_m = std::min(4.0, 5 * (t - 5));
    if (t >= 15) sample.pose.x_m = 4;
  });
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].what.rfind("hit something at 5.0 m/s", 0), 0U) << found[0].what;
}

TEST(Incident, TiltCountsFromTheVerticalInTheAirOnly) {
  const auto tilted = [](double from, double roll, double pitch) {
    return incidents_of([=](double t, PoseSample& sample) {
      good_height(t, sample);
      if (t < from || t > from + 0.5) return;
      sample.pose.roll_rad = roll;
      sample.pose.pitch_rad = pitch;
    });
  };
  EXPECT_TRUE(tilted(7, 1.30, 0).empty()) << "74.5 degrees";
  EXPECT_TRUE(tilted(0.2, 3.1, 0).empty()) << "before takeoff";
  ASSERT_EQ(tilted(7, 1.32, 0).size(), 1U) << "75.6 degrees";
  EXPECT_EQ(tilted(7, 1.1, 1.1).at(0).kind, IncidentKind::kAttitude) << "78 degrees together";
}

TEST(Incident, TenTimesTheExtentOfThePlanIsAFlyaway) {
  const auto at = [](double x_m) {
    return incidents_of([x_m](double t, PoseSample& sample) {
      good_height(t, sample);
      if (t > 5 && t < 15) sample.pose.x_m = x_m * std::pow(std::sin(M_PI * (t - 5) / 10), 2);
    });
  };
  EXPECT_TRUE(at(99).empty());
  const auto gone = at(101);
  ASSERT_EQ(gone.size(), 1U);
  EXPECT_EQ(gone[0].kind, IncidentKind::kFlyaway);
}

TEST(Incident, APlaceThatIsNoNumberIsAFlyaway) {
  const auto found = incidents_of([](double t, PoseSample& sample) {
    good_height(t, sample);
    if (t > 8) sample.pose.x_m = std::nan("");
  });
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, IncidentKind::kFlyaway);
}

/// The rotors turn in the air; one is given its own speed.
Path with_rotor(std::function<double(double t)> first) {
  return [first = std::move(first)](double t, PoseSample& sample) {
    good_height(t, sample);
    sample.omega_rad_s.fill(t < 24 ? 700.0 : 0.0);
    if (t < 24) sample.omega_rad_s[0] = first(t);
  };
}

TEST(Incident, ARotorThatStopsAtOnceHasHitSomething) {
  const auto found = incidents_of(with_rotor([](double t) { return t < 7 ? 700.0 : 0.0; }));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, IncidentKind::kStrike);
  EXPECT_NEAR(found[0].time_s, 7.0, 0.02);
  EXPECT_EQ(found[0].what.rfind("hit something with rotor 1, which stopped in step 'hold'", 0), 0U)
      << found[0].what;
}

TEST(Incident, ARotorThatIsSwitchedOffHasHitNothing) {
  const auto lag = [](double t) { return t < 7 ? 700.0 : 700.0 * std::exp(-(t - 7) / 0.025); };
  EXPECT_TRUE(incidents_of(with_rotor(lag)).empty()) << "one fails: it runs down";
  EXPECT_TRUE(incidents_of(with_rotor([](double) { return 700.0; })).empty()) << "all are disarmed";
}

sim::Shape shape_at(const std::string& name, sim::Geometry geometry, double east_m) {
  sim::Shape shape;
  shape.name = name;
  shape.geometry = std::move(geometry);
  shape.pose.translate(Eigen::Vector3d(east_m, 0, 0));
  return shape;
}

TEST(StruckObject, IsTheNearestModelWithinReach) {
  const auto triangle = std::make_shared<sim::TriangleMesh>(
      sim::TriangleMesh{{{0, 0, 0}, {0, 8, 0}, {0, 0, 8}}, {{0, 1, 2}}});
  sim::WorldModel world;
  world.statics = {
      shape_at("ground/plane", sim::Plane{}, 0), shape_at("house/wall", sim::Box{{2, 20, 5}}, 10),
      shape_at("tower", sim::Cylinder{.radius_m = 1, .length_m = 40}, 20),
      shape_at("ball", sim::Sphere{.radius_m = 1}, 30), shape_at("roof", sim::Mesh{triangle}, 40)};
  const auto nearest = [&](double east_m, double north_m, double up_m) {
    return nearest_object(world, 0, {east_m, north_m, up_m}, 2);
  };
  EXPECT_EQ(nearest(8, 9, 1), "house");
  EXPECT_EQ(nearest(18, 0, 15), "tower");
  EXPECT_EQ(nearest(30, 2.5, 0), "ball");
  EXPECT_EQ(nearest(41, 2, 2), "roof");     // above its face
  EXPECT_EQ(nearest(40, -1.5, 2), "roof");  // beside its edge
  EXPECT_EQ(nearest(40, 8, 8), "");         // beyond the face, where its triangle ends
  EXPECT_EQ(nearest(0, 0, 0.1), "");        // on the ground alone
}

}  // namespace
}  // namespace cas::hils
