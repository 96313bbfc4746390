// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/start.hpp"

#include <gtest/gtest.h>

#include "tests/libsim/support/crate.hpp"
#include "tests/support/refusal.hpp"

namespace cas::sim {
namespace {

/// A body of 1 kg.
VehicleModel body() {
  VehicleModel model;
  model.mass = MassProperties(1, 0.01 * Eigen::Matrix3d::Identity());
  model.shapes.push_back({.name = "body", .geometry = Box{{0.3, 0.3, 0.1}}, .surface = {}});
  return model;
}

/// A plate whose upper side is at `top_m`, under gravity.
WorldModel plate(double top_m, double width_m) {
  WorldModel world;
  world.name = "plates";
  world.gravity_W = {0, 0, -9.80665};
  Shape plate{.name = "plate", .geometry = Box{{width_m, width_m, 0.1}}, .surface = {}};
  plate.pose.translation().z() = top_m - 0.05;
  world.statics.push_back(plate);
  return world;
}

VehicleConfig vehicle_at(double x_m, double z_m) {
  VehicleConfig vehicle;
  vehicle.name = "a";
  vehicle.pose.x_m = x_m;
  vehicle.pose.z_m = z_m;
  return vehicle;
}

/// Whether the body may start at z = 0 over a plate whose upper side is at `top_m`.
bool starts(double top_m) {
  const WorldModel model = plate(top_m, 200);
  const auto world = test::make_world(model);
  return cas::test::refusal([&] { require_free_start(*world, model, body(), vehicle_at(0, 0)); })
      .empty();
}

/// PX4's worlds have a plate of asphalt whose upper side is 5 cm above the ground.
TEST(Start, APlateOfFiveCentimetresIsASurfaceWhateverIsRounded) {
  EXPECT_TRUE(starts(0));
  EXPECT_TRUE(starts(0.05));
  EXPECT_TRUE(starts(0.0505));
  EXPECT_FALSE(starts(0.055));
}

std::string refused_ground(const WorldModel& model, double x_m, double z_m) {
  const auto world = test::make_world(model);
  return cas::test::refusal(
      [&] { require_ground(*world, model, body(), vehicle_at(x_m, z_m), "w.sdf"); });
}

TEST(Start, NeedsGroundBelowIt) {
  const WorldModel world = plate(0, 10);
  EXPECT_EQ(refused_ground(world, 0, 0), "");
  EXPECT_EQ(refused_ground(world, 0, 500), "") << "high in the air";
  EXPECT_EQ(refused_ground(world, 5.1, 0), "") << "with its edge alone over the plate's";
  const std::string beside = refused_ground(world, 5.2, 0);
  EXPECT_NE(beside.find("w.sdf: the world 'plates' has no ground below the start of vehicle 'a' "
                        "(x_m 5.20, y_m 0.00, z_m 0.00)"),
            std::string::npos)
      << beside;
  EXPECT_NE(beside.find("model://ground_plane"), std::string::npos) << beside;
  EXPECT_NE(refused_ground(world, 0, -3), "") << "below the plate";

  WorldModel space = world;
  space.gravity_W.setZero();
  EXPECT_EQ(refused_ground(space, 5.2, 0), "") << "nothing falls there";

  WorldModel wall = world;
  wall.statics.front().geometry = Plane{};
  wall.statics.front().pose.linear() =
      Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitY()).toRotationMatrix();  // faces east
  EXPECT_NE(refused_ground(wall, 5, 0), "");
}

}  // namespace
}  // namespace cas::sim
