// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "libsim/core/ode/ball_on_mesh.hpp"
#include "libsim/core/ode/cylinder_base.hpp"
#include "libsim/core/run/sim_world.hpp"
#include "tests/libsim/support/crate.hpp"
#include "tests/libsim/support/triangles.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;
using test::crate;
using test::flat_world;
using test::ground_of_triangles;
using test::kGravity;
using test::kSensorStd;
using test::kStep_s;
using test::kVehicle;
using test::make_world;
using test::standing;
using test::started;

/// Four thrusts that differ by some per cent of each.
class UnequalThrusts final : public ForceModel {
 public:
  UnequalThrusts(double newton, double arm_m) : newton_(newton), arm_m_(arm_m) {}
  int state_count() const override { return 0; }
  void initial_states(std::span<double>) const override {}
  void evaluate(const BodyState&, const Environment&, std::span<const double>, std::span<double>,
                Wrench& wrench) const override {
    struct Rotor {
      double x, y, share;
    };
    for (const auto& [x, y, share] :
         {Rotor{1, 1, 1.05}, Rotor{-1, 1, 0.985}, Rotor{-1, -1, 0.95}, Rotor{1, -1, 1.025}}) {
      const Vector3d thrust_B(0, 0, newton_ / 4 * share);
      wrench.force_B += thrust_B;
      wrench.torque_B += Vector3d(arm_m_ * x, arm_m_ * y, 0.02).cross(thrust_B);
    }
  }

 private:
  double newton_;
  double arm_m_;
};

/// A vehicle whose shape is a standing cylinder; its inertia is that of a crate of the same size.
VehicleModel can(double radius, double length, double mass) {
  VehicleModel model = crate({2 * radius, 2 * radius, length}, mass);
  model.shapes.front().geometry = Cylinder{radius, length};
  return model;
}

WorldModel plate() {
  WorldModel model = flat_world();
  model.statics = {standing("plate", Box{{20, 20, 1}}, {0, 0, -0.5})};
  return model;
}

TEST(StandingCylinder, RestsUnderUnequalThrustsBelowItsWeight) {
  struct GroundCase {
    const char* name;
    WorldModel world;
  };
  const GroundCase rows[] = {
      {"APlane", flat_world()}, {"ABox", plate()}, {"Triangles", ground_of_triangles(0.25)}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    struct Size {
      const char* name;
      VehicleModel model;
      double arm_m;
    };
    for (const auto& [name, model, arm_m] :
         {Size{"flat", can(0.06, 0.025, 0.027), 0.03}, Size{"tall", can(0.1, 0.4, 1.5), 0.15}}) {
      for (const double share : {0.3, 0.5, 0.7}) {
        const auto world = make_world(row.world);
        world->add_vehicle(model, {.yaw_deg = 17});
        UnequalThrusts thrusts(share * model.mass.mass_kg() * kGravity, arm_m);
        world->add_force_model(kVehicle, thrusts);
        world->start();
        double largest = 0;
        Vector3d before = Vector3d::Zero();
        for (int i = 0; i < 6000; ++i) {
          world->advance(kStep_s);
          if (i < 3000) continue;
          if (i == 3000) before = world->state(kVehicle).p_WB;
          largest = std::max(largest, world->state(kVehicle).a_WB.norm());
        }
        EXPECT_EQ(largest, 0) << name << ", thrust " << share << " of the weight: it is held";
        EXPECT_EQ(world->state(kVehicle).p_WB, before) << name;
      }
    }
  }
}

TEST(BasePoints, OfAStandingCylinderAreInPlaceOnIt) {
  const PlacedCylinder cylinder{{0, 0, 0.099}, Eigen::Matrix3d::Identity(), 0.05, 0.2};
  const auto points = base_points(cylinder, {Vector3d::UnitZ(), 0});
  EXPECT_TRUE(points[0].isApprox(Vector3d(0.05, 0, -0.001)));
  EXPECT_TRUE(points[1].isApprox(Vector3d(0, 0.05, -0.001)));
  EXPECT_TRUE(points[2].isApprox(Vector3d(0, -0.05, -0.001)));
  EXPECT_TRUE(points[3].isApprox(Vector3d(-0.05, 0, -0.001)));
  EXPECT_NEAR(points[4].z(), 0.199, 1e-12);
}

TEST(BasePoints, OfALeaningCylinderBeginWithItsLowest) {
  for (const double azimuth : {0.0, 0.7, 2.0, 4.5}) {
    const Vector3d axis(-std::sin(azimuth), std::cos(azimuth), 0);
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.3, axis).toRotationMatrix();
    const PlacedCylinder cylinder{{0, 0, 0.1}, R, 0.05, 0.2};
    const auto points = base_points(cylinder, {Vector3d::UnitZ(), 0});
    // The rim's lowest point: half the length and the radius, seen from the side.
    const double lowest = 0.1 - 0.1 * std::cos(0.3) - 0.05 * std::sin(0.3);
    EXPECT_NEAR(points[0].z(), lowest, 1e-12) << azimuth;
    const Vector3d towards = points[0].normalized();
    EXPECT_GT(towards.dot(Vector3d(std::cos(azimuth), std::sin(azimuth), 0)), 0.01)
        << "it leans towards " << azimuth;
  }
}

TEST(BasePoints, OfALyingCylinderAreTheEndsOfItsLine) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY()).toRotationMatrix();
  const auto points = base_points({{0, 0, 0.049}, R, 0.05, 0.2}, {Vector3d::UnitZ(), 0});
  EXPECT_NEAR(points[0].z(), -0.001, 1e-12);
  EXPECT_NEAR(points[4].z(), -0.001, 1e-12);
  EXPECT_NEAR((points[0] - points[4]).norm(), 0.2, 1e-9);
}

TEST(NearestPoint, OfATriangleIsInsideOnASideOrACorner) {
  const Triangle triangle{Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
  struct Case {
    Vector3d p, nearest;
  };
  for (const auto& [p, nearest] :
       {Case{{0.2, 0.3, 5}, {0.2, 0.3, 0}}, Case{{0.4, -1, 0}, {0.4, 0, 0}},
        Case{{-1, 0.4, 1}, {0, 0.4, 0}}, Case{{1, 1, -1}, {0.5, 0.5, 0}},
        Case{{-1, -1, 0}, {0, 0, 0}}, Case{{3, -1, 2}, {1, 0, 0}}, Case{{-1, 3, 0}, {0, 1, 0}}}) {
    EXPECT_TRUE(nearest_point(triangle, p).isApprox(nearest)) << p.transpose();
  }
}

BallContact contact(const Vector3d& p_W, const Vector3d& n_W, double depth_m, bool is_face) {
  return {
      .triangle = 0, .p_W = p_W, .n_W = n_W.normalized(), .depth_m = depth_m, .is_face = is_face};
}

TEST(SidesOfFaces, CountOnlyWhereTheyStandOutOfTheFace) {
  std::vector<BallContact> contacts{
      contact({0.01, 0, 0}, {-0.2, 0, 1}, 5e-4, false),     // a side of the same plane
      contact({0, 0, 0}, {0, 0, 1}, 1e-3, true),            // the face
      contact({0.02, 0, 5e-3}, {-0.5, 0, 1}, 5e-4, false),  // the edge of a step
  };
  drop_sides_of_faces(contacts);
  ASSERT_EQ(contacts.size(), 2u);
  EXPECT_TRUE(contacts[0].is_face);
  EXPECT_EQ(contacts[1].p_W.z(), 5e-3);

  std::vector<BallContact> ridge{contact({0, 0, 0}, {0.1, 0, 1}, 1e-3, false),
                                 contact({0, 0, 0}, {0.1, 0, 1}, 1e-3, false)};
  drop_sides_of_faces(ridge);
  EXPECT_EQ(ridge.size(), 2u) << "without a face, sides carry";
}

/// A solid ball that does not slip rolls down at 5/7 of g sin a.
TEST(Ball, RollsDownASlopeAsTheClosedFormSays) {
  struct RollCase {
    const char* name;
    double cell_m;  // of triangles; 0: a plane
  };
  const RollCase rows[] = {
      {"APlane", 0}, {"Triangles25cm", 0.25}, {"Triangles5cm", 0.05}, {"Triangles2cm", 0.02}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    // Friction follows the slip at the begin of a step, and the spring takes a while to settle.
    constexpr double kOfSteps = 0.005;
    constexpr double kSlope = 5 * M_PI / 180;
    constexpr double kRadius = 0.05;
    constexpr double kMass = 0.5;
    WorldModel model = row.cell_m > 0 ? ground_of_triangles(row.cell_m) : flat_world();
    model.gravity_W = kGravity * Vector3d(std::sin(kSlope), 0, -std::cos(kSlope));
    VehicleModel ball = crate();
    ball.shapes.front().geometry = Sphere{kRadius};
    ball.mass =
        MassProperties(kMass, 0.4 * kMass * kRadius * kRadius * Eigen::Matrix3d::Identity());
    const auto world = started(make_world(model), ball, {.x_m = -1.5});
    for (int i = 0; i < 300; ++i) world->advance(kStep_s);
    const Vector3d before = world->state(kVehicle).v_WB;
    constexpr double kTime_s = 1.5;
    for (int i = 0; i < static_cast<int>(kTime_s / kStep_s); ++i) world->advance(kStep_s);
    const Vector3d gained = (world->state(kVehicle).v_WB - before) / kTime_s;
    const double expected = 5.0 / 7.0 * kGravity * std::sin(kSlope);
    EXPECT_NEAR(gained.x(), expected, kOfSteps * expected);
    EXPECT_LT(std::abs(gained.y()), kOfSteps * expected);
    RecordProperty("share", std::to_string(gained.x() / expected));
  }
}

TEST(BallFeet, RestOnSmallTriangles) {
  VehicleModel model = crate();
  model.shapes.clear();
  for (const double x : {-0.15, 0.15}) {
    for (const double y : {-0.15, 0.15}) {
      model.shapes.push_back(standing("foot", Sphere{0.03}, {x, y, -0.1}));
    }
  }
  const auto world = started(make_world(ground_of_triangles(0.05)), model, {.yaw_deg = 17});
  double squares = 0;
  constexpr int kSamples = 2000;
  for (int i = 0; i < 1000 + kSamples; ++i) {
    // Small forces that never hold quite still: the solver is asked in every step.
    world->add_wrench(
        kVehicle, {{0.03 * std::sin(0.03 * i), 0, 0.03 * std::cos(0.02 * i)}, Vector3d::Zero()});
    world->advance(kStep_s);
    if (i >= 1000) squares += world->state(kVehicle).a_WB.squaredNorm();
  }
  EXPECT_LT(std::sqrt(squares / kSamples), kSensorStd);
}

}  // namespace
}  // namespace cas::sim
