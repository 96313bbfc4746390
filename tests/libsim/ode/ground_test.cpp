// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "libsim/core/run/sim_world.hpp"
#include "tests/libsim/support/crate.hpp"
#include "tests/libsim/support/four_rotors.hpp"
#include "tests/libsim/support/triangles.hpp"

namespace cas::sim {
namespace {

using test::crate;
using test::flat_world;
using test::ground_of_triangles;
using test::kCrateMass;
using test::kCrateSize;
using test::kGravity;
using test::kSensorStd;
using test::kStep_s;
using test::kVehicle;
using test::make_world;
using test::standing;
using test::started;

class Triangles : public testing::TestWithParam<int> {};

TEST_P(Triangles, CarryABoxThatStandsStill) {
  for (const double yaw_deg : {0.0, 17.0, 45.0}) {
    const auto world = started(make_world(ground_of_triangles(0.01 * GetParam())), crate(),
                               {.z_m = 0.01, .yaw_deg = yaw_deg});
    double squares = 0;
    int samples = 0;
    for (int i = 0; i < 4000; ++i) {
      // Small forces that never hold quite still: the solver is asked in every step.
      world->add_wrench(kVehicle, {{0.03 * std::sin(0.03 * i), 0, 0.03 * std::cos(0.02 * i)},
                                   Eigen::Vector3d::Zero()});
      world->advance(kStep_s);
      if (i < 1500) continue;
      squares += world->state(kVehicle).a_WB.squaredNorm();
      ++samples;
    }
    const double std_m_s2 = std::sqrt(squares / samples);
    EXPECT_LT(std_m_s2, kSensorStd) << "yaw " << yaw_deg;
    RecordProperty("std_at_yaw_" + std::to_string(static_cast<int>(yaw_deg)),
                   std::to_string(std_m_s2));
  }
}

INSTANTIATE_TEST_SUITE_P(Size, Triangles, testing::Values(2, 10, 20, 50),
                         [](const auto& test) { return std::to_string(test.param) + "cm"; });

/// Hills of 0.3 m and bumps of 3 cm, no two places alike.
double hilly_m(double x, double y) {
  return 0.3 * std::sin(0.9 * x + 0.4) * std::cos(0.7 * y) +
         0.03 * std::sin(5.1 * x) * std::sin(4.3 * y + 1);
}

struct Stand {
  const char* name;
  bool has_feet;
};

class UnevenGround : public testing::TestWithParam<Stand> {};

/// A crate, or one on four balls.
VehicleModel standing_on_hills(bool has_feet) {
  VehicleModel model = crate();
  if (!has_feet) return model;
  for (const double x : {-0.15, 0.15}) {
    for (const double y : {-0.15, 0.15}) {
      Shape foot = model.shapes.front();
      foot.geometry = Sphere{0.03};
      foot.pose.translation() = Eigen::Vector3d(x, y, -0.1);
      model.shapes.push_back(foot);
    }
  }
  return model;
}

/// Whether a place is quiet: after the vehicle has settled, its specific force is within the noise
/// of the quietest sensor, and it stays where it is.
bool is_quiet(const VehicleModel& model, int place) {
  constexpr int kSettled = 6000;
  constexpr int kEnd = 8000;
  constexpr double kCreep_m = 1e-4;
  const auto world = make_world(ground_of_triangles(0.25, 1.0, hilly_m));
  const double x = -2 + 0.37 * place;
  const double y = 1.5 * std::sin(2.3 * place);
  world->add_vehicle(model,
                     {.x_m = x, .y_m = y, .z_m = hilly_m(x, y) + 0.25, .yaw_deg = 31.0 * place});
  world->start();
  double squares = 0;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (int i = 0; i < kEnd; ++i) {
    world->advance(kStep_s);
    if (i == kSettled) before = world->state(kVehicle).p_WB;
    if (i > kSettled) squares += world->state(kVehicle).a_WB.squaredNorm();
  }
  return std::sqrt(squares / (kEnd - kSettled)) < kSensorStd &&
         (world->state(kVehicle).p_WB - before).norm() < kCreep_m;
}

/// At one or two places ODE's contacts of a corner with the sides of a bump still change.
TEST_P(UnevenGround, CarriesABoxThatStandsStill) {
  constexpr int kPlaces = 12;
  const VehicleModel model = standing_on_hills(GetParam().has_feet);
  int quiet = 0;
  for (int place = 0; place < kPlaces; ++place) quiet += is_quiet(model, place) ? 1 : 0;
  EXPECT_GE(quiet, kPlaces - 2);
}

/// Nothing of the flight before is left in the contacts.
TEST_P(UnevenGround, IsTheSameToTheBitAfterAReset) {
  const auto world = started(make_world(ground_of_triangles(0.25, 1.0, hilly_m)),
                             standing_on_hills(GetParam().has_feet), {.z_m = hilly_m(0, 0) + 0.2});
  const auto settled = [&] {
    for (int i = 0; i < 1500; ++i) world->advance(kStep_s);
    return world->state(kVehicle).p_WB;
  };
  const Eigen::Vector3d first = settled();
  world->reset();
  EXPECT_EQ(settled(), first);
}

INSTANTIATE_TEST_SUITE_P(On, UnevenGround,
                         testing::Values(Stand{"ItsFace", false}, Stand{"FourBalls", true}),
                         [](const auto& test) { return std::string(test.param.name); });

/// Flat ground where gravity pulls along the heading, as on a slope of that angle.
/// @param cell_m  of its triangles; 0: a plane
WorldModel slope(double slope_rad, double heading_rad, double friction, double cell_m) {
  WorldModel model = cell_m > 0 ? ground_of_triangles(cell_m, friction) : flat_world(friction);
  model.gravity_W =
      kGravity * Eigen::Vector3d(std::sin(slope_rad) * std::cos(heading_rad),
                                 std::sin(slope_rad) * std::sin(heading_rad), -std::cos(slope_rad));
  return model;
}

TEST(Friction, IsCoulombsInEveryDirection) {
  struct FrictionCase {
    const char* name;
    double friction;
    double slope_deg;
    double cell_m;  // of triangles; 0: a plane
  };
  const FrictionCase rows[] = {{"JustAboveTheAngle", 0.3, 17.5, 0},  // atan 0.3 = 16.7
                               {"Steep", 0.3, 25, 0},
                               {"Rough", 0.8, 42, 0},
                               {"Smooth", 0.05, 10, 0},
                               {"Triangles", 0.3, 22, 0.5},
                               {"SmallTriangles", 0.3, 17.5, 0.1}};
  for (const auto& [name, friction, slope_deg, cell_m] : rows) {
    SCOPED_TRACE(name);
    const double a = slope_deg * M_PI / 180;
    const double expected = kGravity * (std::sin(a) - friction * std::cos(a));
    double largest_error = 0;
    for (double heading_deg = 0; heading_deg <= 90; heading_deg += 7.5) {
      const double heading = heading_deg * M_PI / 180;
      const auto world = started(make_world(slope(a, heading, friction, cell_m)), crate(), {});
      for (int i = 0; i < 300; ++i) world->advance(kStep_s);
      const Eigen::Vector3d before = world->state(kVehicle).v_WB;
      for (int i = 0; i < 700; ++i) world->advance(kStep_s);
      const Eigen::Vector3d gained = (world->state(kVehicle).v_WB - before) / 0.7;
      const Eigen::Vector3d down(std::cos(heading), std::sin(heading), 0);
      EXPECT_NEAR(gained.dot(down), expected, 0.005 * expected) << "heading " << heading_deg;
      EXPECT_LT((gained - gained.dot(down) * down).norm(), 0.005 * expected)
          << "heading " << heading_deg;
      largest_error = std::max(largest_error, (gained - expected * down).norm() / expected);
    }
    RecordProperty("largest_error", std::to_string(largest_error));
  }
}

TEST(Ground, HoldsBelowTheFrictionAngleInEveryDirection) {
  constexpr double kFriction = 0.3;
  const double a = 0.97 * std::atan(kFriction);
  for (double heading_deg = 0; heading_deg <= 90; heading_deg += 7.5) {
    const auto world =
        started(make_world(slope(a, heading_deg * M_PI / 180, kFriction, 0)), crate(), {});
    for (int i = 0; i < 300; ++i) world->advance(kStep_s);
    const Eigen::Vector3d before = world->state(kVehicle).p_WB;
    for (int i = 0; i < 2000; ++i) world->advance(kStep_s);
    EXPECT_LT((world->state(kVehicle).p_WB - before).norm(), 1e-5) << "heading " << heading_deg;
  }
}

TEST(Ground, WhatSlidesAcrossASlopeTurnsDownhill) {
  constexpr double kFriction = 0.3;
  constexpr double kSlope = 25 * M_PI / 180;
  const auto world = started(make_world(slope(kSlope, 0, kFriction, 0)), crate(), {});
  world->add_wrench(kVehicle, {{0, kCrateMass * 1.0 / kStep_s, 0}, Eigen::Vector3d::Zero()});
  world->advance(kStep_s);
  // A point mass under the same friction.
  Eigen::Vector2d v = world->state(kVehicle).v_WB.head<2>();
  const Eigen::Vector2d pull(kGravity * std::sin(kSlope), 0);
  const double drag = kFriction * kGravity * std::cos(kSlope);
  constexpr int kParts = 100;
  for (int i = 0; i < 800; ++i) {
    world->advance(kStep_s);
    for (int part = 0; part < kParts; ++part) {
      v += kStep_s / kParts * (pull - drag * v.normalized());
    }
  }
  EXPECT_LT((world->state(kVehicle).v_WB.head<2>() - v).norm(), 0.01 * v.norm());
}

/// Slides a crate from the middle of the ground at 1 m/s. @return the world after `seconds`
std::unique_ptr<SimWorld> slide(const WorldModel& model, double seconds) {
  auto world = started(make_world(model), crate(), {.yaw_deg = 20});
  const Eigen::Vector3d push_W(kCrateMass * 1.0 / kStep_s, 0, 0);
  world->add_wrench(kVehicle,
                    {world->state(kVehicle).q_WB.conjugate() * push_W, Eigen::Vector3d::Zero()});
  for (int i = 0; i < static_cast<int>(seconds / kStep_s); ++i) world->advance(kStep_s);
  return world;
}

TEST(Ground, WhatSlidesOnSmallTrianglesGoesAsFarAsOnAPlane) {
  constexpr double kFriction = 0.1;
  const auto on_plane = slide(flat_world(kFriction), 1.5);
  const auto on_mesh = slide(ground_of_triangles(0.1, kFriction), 1.5);
  constexpr double kSame = 1e-4;  // m: contacts are searched again each 10 cm
  EXPECT_GT(on_plane->state(kVehicle).p_WB.x(), 0.4);
  EXPECT_LT((on_mesh->state(kVehicle).p_WB - on_plane->state(kVehicle).p_WB).norm(), kSame);
}

TEST(Ground, WhatSlidesOnAMeshFallsOverItsEdgeAndStopsAtAWall) {
  WorldModel edge = ground_of_triangles(0.1, 0.05);
  edge.statics.front().pose.translation().x() = -2.6;  // its edge 0.4 m ahead
  EXPECT_LT(slide(edge, 1.5)->state(kVehicle).p_WB.z(), -0.5);

  WorldModel wall = ground_of_triangles(0.1, 0.05);
  wall.statics.push_back(standing("wall", Box{{0.2, 4, 1}}, {0.6, 0, 0.5}));  // 0.5 m ahead
  double reach = 0;
  for (const double time_s : {0.3, 0.6, 1.5}) {
    reach = std::max(reach, slide(wall, time_s)->state(kVehicle).p_WB.x());
  }
  EXPECT_LT(reach, 0.5 - kCrateSize.x() / 2 + 0.02);
  EXPECT_GT(reach, 0.15) << "it comes as far as the wall";
}

TEST(Landing, AtOneMetrePerSecondIsFeltBelow15G) {
  struct LandingCase {
    const char* name;
    double tilt_deg;
    double axis_deg;  // about which it is tilted, from ahead: 0 an edge comes first, 45 a corner
    double mass_kg;
    int step_us;
  };
  const LandingCase rows[] = {{"Flat", 0, 0, 1.5, 1000},
                              {"FlatShortSteps", 0, 0, 1.5, 250},
                              {"FlatLongSteps", 0, 0, 1.5, 4000},
                              {"Small", 0, 0, 0.03, 1000},
                              {"Large", 0, 0, 25, 1000},
                              {"Tilted1", 1, 0, 1.5, 1000},
                              {"Tilted3", 3, 0, 1.5, 1000},
                              {"Tilted10", 10, 0, 1.5, 1000},
                              {"Tilted10ShortSteps", 10, 0, 1.5, 250},
                              {"Tilted10LongSteps", 10, 0, 1.5, 4000},
                              {"Tilted25", 25, 0, 1.5, 1000},
                              {"OnACorner3", 3, 45, 1.5, 1000},
                              {"OnACorner10", 10, 45, 1.5, 1000},
                              {"OnACorner25", 25, 45, 1.5, 1000}};
  for (const auto& [name, tilt_deg, axis_deg, mass_kg, step_us] : rows) {
    SCOPED_TRACE(name);
    const double dt = 1e-6 * step_us;
    VehicleModel model = crate(kCrateSize, mass_kg);
    const auto world = make_world(flat_world());
    const double fall = 1.0 / (2 * kGravity);  // to 1 m/s
    world->add_vehicle(model, {.z_m = fall + (tilt_deg > 0 ? 0.15 : 0)});
    test::SteadyThrust hover(mass_kg * kGravity);
    if (tilt_deg > 0) world->add_force_model(kVehicle, hover);
    world->start();
    if (tilt_deg > 0) {
      // Tilted within 0.1 s, then set sinking; thrust alone acts.
      const double axis = axis_deg * M_PI / 180;
      const Eigen::Vector3d turn =  // rad/s
          tilt_deg * M_PI / 180 / 0.1 * Eigen::Vector3d(std::cos(axis), std::sin(axis), 0);
      const double i_xx = model.mass.inertia_B()(0, 0);  // and i_yy
      world->add_wrench(kVehicle, {Eigen::Vector3d::Zero(), i_xx / dt * turn});
      for (int i = 0; i < static_cast<int>(std::lround(0.1 / dt)); ++i) world->advance(dt);
      const Eigen::Vector3d down_B =
          world->state(kVehicle).q_WB.conjugate() * Eigen::Vector3d(0, 0, -mass_kg / dt);
      world->add_wrench(kVehicle, {down_B, -i_xx / dt * turn});
    }
    double largest = 0;
    double rebound = 0;
    bool landed = false;
    for (int i = 0; i < static_cast<int>(1.0 / dt); ++i) {
      world->advance(dt);
      if (i == 0) continue;
      landed = landed || world->in_contact(kVehicle);
      const Eigen::Vector3d felt = world->state(kVehicle).a_WB + Eigen::Vector3d(0, 0, kGravity);
      largest = std::max(largest, felt.norm());
      if (landed) rebound = std::max(rebound, world->state(kVehicle).v_WB.z());
    }
    RecordProperty("largest_g", std::to_string(largest / kGravity));
    EXPECT_TRUE(landed);
    EXPECT_LT(largest, 15 * kGravity);
    EXPECT_GT(largest, 2 * kGravity);
    if (tilt_deg == 0) {
      EXPECT_LT(rebound, 0.2);
    }
  }
}

TEST(Ground, StiffnessOfTheFileSaysHowDeepItGives) {
  constexpr double kStiffness = 2e3;  // N/m
  WorldModel model = flat_world();
  model.statics.front().surface.stiffness_n_m = kStiffness;
  model.statics.front().surface.damping_n_s_m = 100;
  const auto world = started(make_world(model), crate(), {});
  for (int i = 0; i < 2000; ++i) world->advance(kStep_s);
  const double sunk = kCrateSize.z() / 2 - world->state(kVehicle).p_WB.z();
  EXPECT_NEAR(sunk, kCrateMass * kGravity / (4 * kStiffness), 2e-5) << "a spring at each corner";
}

TEST(Ground, OdeDoesNotComplainOfTrianglesAndCorners) {
  const std::uint64_t before = ContactSolver::complaints();
  testing::internal::CaptureStderr();
  WorldModel model = ground_of_triangles(0.1);
  model.statics.push_back(standing("wall", Box{{0.2, 4, 2}}, {0.4, 0, 1}));
  const auto world = started(make_world(model), crate(), {.z_m = 0.2, .yaw_deg = 10});
  for (int i = 0; i < 4000; ++i) {
    const double side = 12 * std::sin(0.004 * i);
    world->add_wrench(kVehicle, {{side, 3, 0}, {0.1, 0.2 * std::sin(0.02 * i), 0}});
    world->advance(kStep_s);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(ContactSolver::complaints(), before);
}

Shape upright(const Geometry& geometry) { return standing("pole", geometry); }

/// A square of two triangles across x.
Shape screen() {
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = {{0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  return standing("screen", Mesh{mesh});
}

TEST(DiscTouches, WhatStandsInItsWay) {
  struct DiscCase {
    const char* name;
    Shape obstacle;
    double reach_m;  // of the obstacle along -x from its middle
  };
  const DiscCase rows[] = {{"Pole", upright(Cylinder{0.02, 4.0}), 0.02},
                           {"Wall", upright(Box{{0.2, 3, 3}}), 0.1},
                           {"Ball", upright(Sphere{0.3}), 0.3},
                           {"Triangles", screen(), 0}};
  for (const auto& [name, obstacle, reach_m] : rows) {
    SCOPED_TRACE(name);
    constexpr double kRadius = 0.128;
    constexpr double kArm = 0.2;
    WorldModel model;
    model.gravity_W = {0, 0, -kGravity};
    model.statics.push_back(obstacle);
    for (const double gap : {-0.01, 0.01}) {
      const auto world = make_world(model);
      const double x = -(reach_m + kArm + kRadius + gap);
      world->add_vehicle(crate({0.1, 0.1, 0.1}), {.x_m = x, .z_m = -0.05});
      world->start();
      EXPECT_EQ(world->disc_touches(kVehicle, {kArm, 0, 0}, Eigen::Vector3d::UnitZ(), kRadius),
                gap < 0)
          << gap;
      EXPECT_FALSE(world->disc_touches(kVehicle, {-kArm, 0, 0}, Eigen::Vector3d::UnitZ(), kRadius));
    }
  }
}

TEST(Disc, TouchesTheGroundWhenTiltedAndOtherVehicles) {
  const auto world = make_world(flat_world());
  world->add_vehicle(crate(), {});
  world->add_vehicle(crate(), {.x_m = 0.6});
  world->start();
  EXPECT_FALSE(world->disc_touches(kVehicle, {-0.2, 0, 0.02}, Eigen::Vector3d::UnitZ(), 0.128))
      << "level, above the ground";
  EXPECT_TRUE(world->disc_touches(kVehicle, {-0.2, 0, -0.06}, Eigen::Vector3d::UnitZ(), 0.128))
      << "below it";
  EXPECT_FALSE(world->disc_touches(kVehicle, {0.2, 0, 0.02}, Eigen::Vector3d::UnitZ(), 0.128))
      << "72 mm off the other";
  EXPECT_TRUE(world->disc_touches(kVehicle, {0.3, 0, 0.02}, Eigen::Vector3d::UnitZ(), 0.128));
}

/// A disc whose axis leans by an angle a reaches R sin(a) below its centre, on one side.
TEST(Disc, LeansWithItsAxis) {
  const auto world = started(make_world(flat_world()), crate(), {});
  constexpr double kRadius = 0.2;
  constexpr double kLean = 0.5;
  constexpr double kGap = 1e-3;  // m: the disc has a small thickness
  const Eigen::Vector3d axis_B(0, -std::sin(kLean), std::cos(kLean));
  const double ground_B = -world->state(kVehicle).p_WB.z();  // the vehicle is level
  const double lowest = kRadius * std::sin(kLean);
  EXPECT_FALSE(world->disc_touches(kVehicle, {0, 0, ground_B + lowest + kGap}, axis_B, kRadius));
  EXPECT_TRUE(world->disc_touches(kVehicle, {0, 0, ground_B + lowest - kGap}, axis_B, kRadius));
  EXPECT_FALSE(world->disc_touches(kVehicle, {0, 0, ground_B + lowest - kGap},
                                   Eigen::Vector3d::UnitZ(), kRadius));
}

}  // namespace
}  // namespace cas::sim
