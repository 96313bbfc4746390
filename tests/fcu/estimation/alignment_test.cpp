// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/alignment.hpp"

#include <gtest/gtest.h>

#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"

namespace cas::fcu {
namespace {

using Eigen::Vector3d;

const Vector3d kField_N(0.2, 0.01, 0.4);
constexpr double kRoll = -0.18;  // rad, of the slope

base::SimTime at(double seconds) { return base::SimTime(base::from_seconds(seconds)); }

/// Specific force of a vehicle at rest with that roll.
Vector3d at_rest(double roll_rad) {
  return base::quaternion_rpy(roll_rad, 0, 0).conjugate() *
         Vector3d(0, 0, -base::kStandardGravity_m_s2);
}

TEST(Rest, IsGravityAndHardlyARate) {
  EXPECT_TRUE(indicates_rest({0.1, 0, 0}, at_rest(kRoll), base::kStandardGravity_m_s2));
  EXPECT_FALSE(indicates_rest({0.2, 0, 0}, at_rest(kRoll), base::kStandardGravity_m_s2))
      << "it tips over";
  EXPECT_FALSE(indicates_rest(Vector3d::Zero(), 0.1 * at_rest(0), base::kStandardGravity_m_s2))
      << "it falls";
  EXPECT_FALSE(indicates_rest(Vector3d::Zero(), 1.5 * at_rest(0), base::kStandardGravity_m_s2))
      << "it hits the ground";
}

/// Feeds 500 samples a second. @return time at which the alignment was complete, s; -1: not within
/// `end_s`
template <class Motion>
double completed(Alignment& alignment, double end_s, const Motion& is_at_rest) {
  for (int i = 0; i < static_cast<int>(500 * end_s); ++i) {
    const double t = i / 500.0;
    const bool rests = is_at_rest(t);
    alignment.on_accelerometer(at(t), at_rest(rests ? kRoll : 0), rests);
    if (i % 5 == 0) {
      alignment.on_magnetometer(base::quaternion_rpy(rests ? kRoll : 0, 0, 0).conjugate() *
                                kField_N);
    }
    if (alignment.has_heading() && alignment.complete(true)) return t;
  }
  return -1;
}

TEST(Alignment, TakesHalfASecondAtRest) {
  Alignment alignment;
  EXPECT_NEAR(completed(alignment, 2, [](double) { return true; }), 0.5, 1e-9);
}

TEST(Alignment, OfAVehicleThatTipsOntoASlopeIsThatOfTheSlope) {
  Alignment alignment;
  const double t = completed(alignment, 3, [](double time) { return time > 0.8; });
  EXPECT_NEAR(t, 0.8 + 0.5, 0.01);
  const Vector3d rpy = base::euler_rpy(alignment.attitude(kField_N, true));
  EXPECT_NEAR(rpy.x(), kRoll, 1e-9);
  EXPECT_NEAR(rpy.y(), 0, 1e-9);
  EXPECT_NEAR(rpy.z(), 0, 1e-9);
}

TEST(Alignment, DoesNotWaitForEverForRest) {
  Alignment alignment;
  EXPECT_NEAR(completed(alignment, 8, [](double) { return false; }), 5 + 0.5, 0.01);
}

}  // namespace
}  // namespace cas::fcu
