// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/frames.hpp"

#include <gtest/gtest.h>

namespace cas::base {
namespace {

constexpr double kRounding = 1e-12;

TEST(Frames, EastNorthUpBecomesNorthEastDown) {
  EXPECT_EQ(swap_WN({1, 2, 3}), Eigen::Vector3d(2, 1, -3));
  EXPECT_EQ(swap_WN(swap_WN({1, 2, 3})), Eigen::Vector3d(1, 2, 3));
}

TEST(Frames, ForwardLeftUpBecomesForwardRightDown) {
  EXPECT_EQ(swap_BD({1, 2, 3}), Eigen::Vector3d(1, -2, -3));
  EXPECT_EQ(swap_BD(swap_BD({1, 2, 3})), Eigen::Vector3d(1, 2, 3));
}

TEST(Frames, ABodyFacingNorthInWHasYawZeroInN) {
  const Eigen::Quaterniond q_WB(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(euler_rpy(q_ND_from_q_WB(q_WB)).isZero(kRounding));
}

TEST(Frames, ABodyFacingEastInWHasYawNinetyDegreesInN) {
  EXPECT_TRUE(euler_rpy(q_ND_from_q_WB(Eigen::Quaterniond::Identity()))
                  .isApprox(Eigen::Vector3d(0, 0, M_PI / 2), kRounding));
}

// The same physical vector, rotated in either pair of frames.
TEST(Frames, AttitudesOfBothConventionsTurnAVectorAlike) {
  const Eigen::Quaterniond q_WB = quaternion_rpy(0.3, -0.7, 2.1);
  const Eigen::Quaterniond q_ND = q_ND_from_q_WB(q_WB);
  const Eigen::Vector3d v_B(0.4, -1.2, 2.5);
  EXPECT_TRUE((q_ND * swap_BD(v_B)).isApprox(swap_WN(q_WB * v_B), kRounding));
  EXPECT_NEAR(q_WB_from_q_ND(q_ND).angularDistance(q_WB), 0.0, 1e-7);
}

TEST(Frames, EulerAnglesSurviveTheRoundTrip) {
  for (double roll = -3.0; roll <= 3.0; roll += 0.5) {
    for (double pitch = -1.5; pitch <= 1.5; pitch += 0.25) {
      for (double yaw = -3.0; yaw <= 3.0; yaw += 0.5) {
        const Eigen::Vector3d rpy(roll, pitch, yaw);
        EXPECT_TRUE((euler_rpy(quaternion_rpy(roll, pitch, yaw)) - rpy).isZero(1e-9));
      }
    }
  }
}

TEST(Frames, PositiveRollTurnsTheRightSideDown) {
  const Eigen::Quaterniond q_ND = quaternion_rpy(0.1, 0, 0);
  EXPECT_GT((q_ND * Eigen::Vector3d::UnitY()).z(), 0);
}

TEST(Frames, PositivePitchTurnsTheNoseUp) {
  const Eigen::Quaterniond q_ND = quaternion_rpy(0, 0.1, 0);
  EXPECT_LT((q_ND * Eigen::Vector3d::UnitX()).z(), 0);
}

TEST(Frames, WrappedAnglesLieWithinHalfATurn) {
  EXPECT_NEAR(wrap_angle(3 * M_PI / 2), -M_PI / 2, kRounding);
  EXPECT_NEAR(wrap_angle(-7 * M_PI / 3), -M_PI / 3, kRounding);
  EXPECT_NEAR(wrap_angle(1.0), 1.0, kRounding);
}

}  // namespace
}  // namespace cas::base
