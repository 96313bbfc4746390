// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/attitude_controller.hpp"

#include <gtest/gtest.h>

#include "base/earth/frames.hpp"
#include "fcu/control/position_controller.hpp"

namespace cas::fcu {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

AttitudeController controller() {
  AttitudeController c;
  c.set_params(ControlParams{});
  return c;
}

TEST(AttitudeController, AsksForNothingWhenItIsThere) {
  AttitudeSetpoint setpoint;
  setpoint.q_ND = base::quaternion_rpy(0.2, -0.1, 1.0);
  EXPECT_LT(controller().update(setpoint, setpoint.q_ND).norm(), 1e-12);
}

TEST(AttitudeController, TurnsTowardsSmallErrorsInProportion) {
  AttitudeSetpoint setpoint;
  setpoint.q_ND = base::quaternion_rpy(0.01, -0.02, 0);
  const Vector3d tilt = controller().update(setpoint, Quaterniond::Identity());
  EXPECT_NEAR(tilt.x(), 6.5 * 0.01, 1e-3);
  EXPECT_NEAR(tilt.y(), 6.5 * -0.02, 1e-3);
  setpoint.q_ND = base::quaternion_rpy(0, 0, 0.03);
  EXPECT_NEAR(controller().update(setpoint, Quaterniond::Identity()).z(), 2.8 * 0.03, 1e-3);
}

TEST(AttitudeController, TakesTheShortWayRound) {
  AttitudeSetpoint setpoint;
  setpoint.q_ND = base::quaternion_rpy(0, 0, -3.0);
  const Quaterniond q = base::quaternion_rpy(0, 0, 3.0);
  EXPECT_GT(controller().update(setpoint, q).z(), 0);
  Quaterniond negated = setpoint.q_ND;
  negated.coeffs() = -negated.coeffs();
  AttitudeSetpoint same = setpoint;
  same.q_ND = negated;
  EXPECT_TRUE(controller().update(same, q).isApprox(controller().update(setpoint, q), 1e-9));
}

TEST(AttitudeController, RightsTheVehicleBeforeItTurns) {
  AttitudeSetpoint setpoint;
  setpoint.q_ND = base::quaternion_rpy(0.5, 0, 1.5);
  const Vector3d w = controller().update(setpoint, Quaterniond::Identity());
  // The tilt asked for lies along the axis of the turned roll: forward is now to the right.
  const Vector3d tilt_axis(std::cos(1.5), std::sin(1.5), 0);
  EXPECT_GT(w.head<2>().dot(tilt_axis.head<2>()), 2.0);
}

TEST(AttitudeController, KeepsWithinTheRateLimits) {
  ControlParams params;
  params.rate_limit_rad_s = {1, 2, 0.5};
  AttitudeController c;
  c.set_params(params);
  AttitudeSetpoint setpoint;
  setpoint.q_ND = base::quaternion_rpy(3, 1, 2);
  const Vector3d w = c.update(setpoint, Quaterniond::Identity());
  EXPECT_TRUE((w.cwiseAbs().array() <= params.rate_limit_rad_s.array() + 1e-12).all());
}

// Thrust and direction.

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
