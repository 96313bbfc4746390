// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/position_controller.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::fcu {
namespace {

using Eigen::Vector3d;

constexpr double kMass = 1.55;
constexpr double kGravity = 9.80665;
constexpr ThrustLimits kLimits{2.0, 28.0, 0.785};

TEST(ThrustSetpoint, HoversLevelOnItsWeight) {
  const auto t = thrust_for_acceleration(Vector3d::Zero(), kMass, kGravity, 0.7, kLimits);
  EXPECT_NEAR(t.attitude.thrust_n, kMass * kGravity, 1e-9);
  EXPECT_TRUE(t.attitude.q_ND.isApprox(base::quaternion_rpy(0, 0, 0.7), 1e-9));
}

TEST(ThrustSetpoint, GivesTheAccelerationItWasAskedFor) {
  const Vector3d a_N(2, -1, -1.5);
  const auto t = thrust_for_acceleration(a_N, kMass, kGravity, -0.4, kLimits);
  const Vector3d force = t.attitude.q_ND * Vector3d(0, 0, -t.attitude.thrust_n);
  EXPECT_TRUE((force / kMass + Vector3d(0, 0, kGravity)).isApprox(a_N, 1e-9));
  EXPECT_NEAR(base::euler_rpy(t.attitude.q_ND).z(), -0.4, 0.1);
}

TEST(ThrustSetpoint, PutsHeightBeforeSidewaysAcceleration) {
  const auto t = thrust_for_acceleration(Vector3d(15, 0, -7.9), kMass, kGravity, 0, kLimits);
  const Vector3d force = t.attitude.q_ND * Vector3d(0, 0, -t.attitude.thrust_n);
  EXPECT_NEAR(-force.z(), kMass * (kGravity + 7.9), 1e-6);
  EXPECT_LE(force.norm(), kLimits.max_n + 1e-9);
  EXPECT_GT(t.cut_N.x(), 1);
}

TEST(ThrustSetpoint, NeverTiltsBeyondTheLimit) {
  const auto t = thrust_for_acceleration(Vector3d(30, 30, 2), kMass, kGravity, 0, kLimits);
  const Vector3d up = t.attitude.q_ND * Vector3d(0, 0, -1);
  EXPECT_LE(std::acos(-up.z()), kLimits.tilt_rad + 1e-9);
}

}  // namespace
}  // namespace cas::fcu
