// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/trajectory.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace cas::fcu {
namespace {

using Eigen::Vector3d;
constexpr double kDt = 0.0025;

TEST(MoverTo, ArrivesWithinItsLimitsWithoutOvershoot) {
  struct Move {
    const char* name;
    Vector3d to;
    double yaw;
  };
  const Move rows[] = {{"Metre", {1, 0, 0}, 0},
                       {"Far", {40, -30, 0}, 2},
                       {"Up", {0, 0, -10}, 0},
                       {"Down", {0, 0, 5}, 0},
                       {"Aslant", {3, 4, -2}, -3}};
  for (const auto& [name, to, yaw] : rows) {
    SCOPED_TRACE(name);
    MoverLimits limits;
    Mover mover;
    mover.set_limits(limits);
    mover.reset(Vector3d::Zero(), Vector3d::Zero(), 0);
    mover.set_target(to);
    mover.set_yaw(yaw);
    const Vector3d way = to.normalized();
    double furthest = 0;
    Vector3d a_before = Vector3d::Zero();
    int steps = 0;
    for (; steps < 20'000 && !(mover.arrived() && steps > 10); ++steps) {
      const TrajectorySetpoint s = mover.update(kDt);
      EXPECT_LE(s.v_N.head<2>().norm(), limits.speed_m_s * 1.02);
      EXPECT_LE(-s.v_N.z(), limits.up_m_s * 1.02);
      EXPECT_LE(s.v_N.z(), limits.down_m_s * 1.02);
      EXPECT_LE(s.a_N.head<2>().norm(), limits.acceleration_m_s2 * 1.001);
      EXPECT_LE((s.a_N - a_before).head<2>().norm() / kDt, limits.jerk_m_s3 * 1.001);
      a_before = s.a_N;
      furthest = std::max(furthest, s.p_N.dot(way));
    }
    EXPECT_LT(steps, 20'000);
    EXPECT_LT(furthest, to.norm() + 0.05);
    EXPECT_LT((mover.position() - to).norm(), 0.06);
  }
}

TEST(Mover, BrakesFromSpeedTowardsATargetBehindIt) {
  Mover mover;
  mover.reset(Vector3d::Zero(), Vector3d(4, 0, 0), 0);
  mover.set_target(Vector3d(-2, 0, 0));
  for (int i = 0; i < 8000; ++i) mover.update(kDt);
  EXPECT_TRUE(mover.arrived());
}

TEST(Mover, StaysWithTheEstimateWhenThatIsMoved) {
  Mover mover;
  mover.reset(Vector3d(1, 2, -3), Vector3d::Zero(), 0);
  mover.shift(Vector3d(0.5, -0.5, 0));
  EXPECT_TRUE(mover.update(kDt).p_N.isApprox(Vector3d(1.5, 1.5, -3), 1e-9));
}

// Patterns.

class PatternOf : public testing::TestWithParam<PatternShape> {};

TEST_P(PatternOf, HasVelocityAndAccelerationThatAreItsDerivatives) {
  const Pattern pattern(GetParam(), 3, 2, 10);
  constexpr double kStep = 1e-4;
  const Vector3d centre(1, 2, -5);
  for (double t = 0.5; t < 20; t += 0.37) {
    const auto before = pattern.at(t - kStep, centre, 0.3);
    const auto now = pattern.at(t, centre, 0.3);
    const auto after = pattern.at(t + kStep, centre, 0.3);
    EXPECT_LT(((after.p_N - before.p_N) / (2 * kStep) - now.v_N).norm(), 1e-4) << t;
    EXPECT_LT(((after.v_N - before.v_N) / (2 * kStep) - now.a_N).norm(), 1e-3) << t;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, PatternOf,
                         testing::Values(PatternShape::kCircle, PatternShape::kFigureEight));

TEST(Pattern, FigureEightReachesItsSpeedAndNoMore) {
  const Pattern pattern(PatternShape::kFigureEight, 4, 2, 10);
  double fastest = 0;
  for (double t = Pattern::kStart_s; t < 60; t += 0.01) {
    fastest = std::max(fastest, pattern.at(t, Vector3d::Zero(), 0).v_N.norm());
  }
  EXPECT_NEAR(fastest, 2, 1e-3);
}

TEST(Pattern, StepsGoForthAndBack) {
  const Pattern pattern(PatternShape::kSteps, 1, 1, 6);
  EXPECT_DOUBLE_EQ(pattern.at(3, Vector3d::Zero(), 0).p_N.x(), 0);
  EXPECT_DOUBLE_EQ(pattern.at(7, Vector3d::Zero(), 0).p_N.x(), 1);
  EXPECT_DOUBLE_EQ(pattern.at(13, Vector3d::Zero(), 0).p_N.x(), 0);
}

}  // namespace
}  // namespace cas::fcu
