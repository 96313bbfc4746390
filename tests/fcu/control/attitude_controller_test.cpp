// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/attitude_controller.hpp"

#include <gtest/gtest.h>

#include "base/earth/frames.hpp"

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
  AttitudeSetpoint setpoint{.q_ND = base::quaternion_rpy(0.2, -0.1, 1.0)};
  EXPECT_LT(controller().update(setpoint, setpoint.q_ND).norm(), 1e-12);
}

TEST(AttitudeController, TurnsTowardsSmallErrorsInProportion) {
  AttitudeSetpoint setpoint{.q_ND = base::quaternion_rpy(0.01, -0.02, 0)};
  const Vector3d tilt = controller().update(setpoint, Quaterniond::Identity());
  EXPECT_NEAR(tilt.x(), ControlParams{}.roll_p * 0.01, 1e-3);
  EXPECT_NEAR(tilt.y(), ControlParams{}.pitch_p * -0.02, 1e-3);
  setpoint.q_ND = base::quaternion_rpy(0, 0, 0.03);
  EXPECT_NEAR(controller().update(setpoint, Quaterniond::Identity()).z(), 2.8 * 0.03, 1e-3);
}

TEST(AttitudeController, TakesTheShortWayRound) {
  AttitudeSetpoint setpoint{.q_ND = base::quaternion_rpy(0, 0, -3.0)};
  const Quaterniond q = base::quaternion_rpy(0, 0, 3.0);
  EXPECT_GT(controller().update(setpoint, q).z(), 0);
  Quaterniond negated = setpoint.q_ND;
  negated.coeffs() = -negated.coeffs();
  AttitudeSetpoint same = setpoint;
  same.q_ND = negated;
  EXPECT_TRUE(controller().update(same, q).isApprox(controller().update(setpoint, q), 1e-9));
}

TEST(AttitudeController, RightsTheVehicleBeforeItTurns) {
  AttitudeSetpoint setpoint{.q_ND = base::quaternion_rpy(0.5, 0, 1.5)};
  const Vector3d w = controller().update(setpoint, Quaterniond::Identity());
  // The tilt asked for lies along the axis of the turned roll: forward is now to the right.
  const Vector3d tilt_axis(std::cos(1.5), std::sin(1.5), 0);
  EXPECT_GT(w.head<2>().dot(tilt_axis.head<2>()), 2.0);
}

/// The tilt alone, as if the vehicle headed where it shall.
TEST(AttitudeController, RightsTheVehicleAtAnyHeadingWhereNoneIsHeld) {
  AttitudeSetpoint level{.yaw_rate_rad_s = 0.3};
  for (const double yaw_rad : {0.0, 1.0, 3.0}) {
    const Quaterniond q = base::quaternion_rpy(0, 0, yaw_rad) * base::quaternion_rpy(0.1, -0.05, 0);
    const Vector3d w = controller().update(level, q, 0);
    EXPECT_NEAR(w.x(), -0.1 * ControlParams{}.roll_p, 2e-3) << yaw_rad;
    EXPECT_NEAR(w.y(), 0.05 * ControlParams{}.pitch_p, 2e-3) << yaw_rad;
    EXPECT_EQ(w.z(), 0) << yaw_rad;
  }
}

TEST(AttitudeController, KeepsWithinTheRateLimits) {
  ControlParams params{.rate_limit_rad_s = {1, 2, 0.5}};
  AttitudeController c;
  c.set_params(params);
  AttitudeSetpoint setpoint{.q_ND = base::quaternion_rpy(3, 1, 2)};
  const Vector3d w = c.update(setpoint, Quaterniond::Identity());
  EXPECT_TRUE((w.cwiseAbs().array() <= params.rate_limit_rad_s.array() + 1e-12).all());
}

}  // namespace
}  // namespace cas::fcu
