// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/start.hpp"

#include <gtest/gtest.h>

#include "tests/support/refusal.hpp"

namespace cas::sim {
namespace {

/// A body of 1 kg over a plate whose upper side is at `top_m`.
bool starts(double top_m) {
  VehicleModel model;
  model.mass = MassProperties(1, 0.01 * Eigen::Matrix3d::Identity());
  model.shapes.push_back({.name = "body", .geometry = Box{{0.3, 0.3, 0.1}}, .surface = {}});
  WorldModel world;
  Shape plate{.name = "plate", .geometry = Box{{200, 200, 0.1}}, .surface = {}};
  plate.pose.translation().z() = top_m - 0.05;
  world.statics.push_back(plate);
  VehicleConfig vehicle;
  vehicle.name = "a";
  vehicle.pose.z_m = 0;
  return test::refusal([&] { require_free_start(world, model, vehicle); }).empty();
}

/// PX4's worlds have a plate of asphalt whose upper side is 5 cm above the ground.
TEST(Start, APlateOfFiveCentimetresIsASurfaceWhateverIsRounded) {
  EXPECT_TRUE(starts(0));
  EXPECT_TRUE(starts(0.05));
  EXPECT_TRUE(starts(0.0505));
  EXPECT_FALSE(starts(0.055));
}

}  // namespace
}  // namespace cas::sim
