// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/total_energy.hpp"

#include <gtest/gtest.h>

namespace cas::fcu {
namespace {

constexpr double kStep_s = 0.004;

WingParams params() {
  WingParams p;
  p.throttle_trim = 0.1;
  p.throttle_max = 0.3;
  p.climb_max_m_s = 5;
  p.sink_min_m_s = 2;
  return p;
}

TotalEnergy::Input level() {
  TotalEnergy::Input in;
  in.airspeed_wanted_m_s = in.airspeed_m_s = 15;
  return in;
}

TotalEnergy::Output once(const TotalEnergy::Input& in) {
  TotalEnergy energy;
  energy.set_params(params());
  return energy.update(in, kStep_s);
}

TEST(TotalEnergy, HoldsTrimWhereNothingIsWanted) {
  const TotalEnergy::Output out = once(level());
  EXPECT_DOUBLE_EQ(out.throttle, 0.1);
  EXPECT_DOUBLE_EQ(out.path_angle_rad, 0);
}

TEST(TotalEnergy, ClimbsByThrottleAndPitchTogether) {
  TotalEnergy::Input in = level();
  in.height_error_m = 3;  // 1 m/s by FW_T_ALT_TC, and as fast already
  in.climb_m_s = 1;
  const TotalEnergy::Output out = once(in);
  EXPECT_NEAR(out.throttle, 0.1 + 0.2 / 5, 1e-9);
  EXPECT_NEAR(out.path_angle_rad, 1.0 / 15, 1e-9);
}

TEST(TotalEnergy, TradesHeightForSpeedWithoutThrottle) {
  // Too high and too slow, by the same energy: the nose goes down, the throttle stays.
  TotalEnergy::Input in = level();
  in.airspeed_m_s = 13;
  in.acceleration_m_s2 = 0.5;  // that of 2 m/s by FW_T_TAS_TC of 4 s
  in.climb_m_s = -0.5 * 13 / 9.80665;
  in.height_error_m = 3 * in.climb_m_s;
  const TotalEnergy::Output out = once(in);
  EXPECT_NEAR(out.throttle, 0.1, 1e-9);
  EXPECT_NEAR(out.path_angle_rad, -0.5 / 9.80665, 1e-9);  // the path that trades one for the other
}

TEST(TotalEnergy, PutsSpeedBeforeHeightWhereItWouldStall) {
  TotalEnergy::Input in = level();
  in.airspeed_m_s = 8;
  in.height_error_m = 20;
  const TotalEnergy::Output out = once(in);
  EXPECT_DOUBLE_EQ(out.throttle, 0.3);
  EXPECT_LT(out.path_angle_rad, 0);
}

TEST(TotalEnergy, FliesTheSinkOfAFlareWhateverHeightAndSpeed) {
  TotalEnergy::Input in = level();
  in.by_climb_alone = true;
  in.height_error_m = 50;
  in.airspeed_m_s = 9;
  in.climb_wanted_m_s = in.climb_m_s = -0.5;
  EXPECT_NEAR(once(in).path_angle_rad, -0.5 / 9, 1e-9);
}

}  // namespace
}  // namespace cas::fcu
