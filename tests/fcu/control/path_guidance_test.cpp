// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/path_guidance.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cas::fcu {
namespace {

using Eigen::Vector2d;

/// A point that flies at one speed and turns as it is told to.
struct Flyer {
  Vector2d p_N = Vector2d::Zero();
  double course_rad = 0;
  double speed_m_s = 15;

  Vector2d v_N() const { return speed_m_s * Vector2d(std::cos(course_rad), std::sin(course_rad)); }
  void fly(const Path& path, const PathGains& gains, double time_s) {
    constexpr double kStep_s = 0.01;
    for (double t = 0; t < time_s; t += kStep_s) {
      const double turn = path_acceleration_m_s2(path, gains, p_N, v_N()) / speed_m_s;
      p_N += kStep_s * speed_m_s *
             Vector2d(std::cos(course_rad + 0.5 * turn * kStep_s),
                      std::sin(course_rad + 0.5 * turn * kStep_s));
      course_rad += turn * kStep_s;
    }
  }
};

TEST(Circle, IsFlownAtItsRadiusWithoutSteadyError) {
  struct CircleCase {
    const char* name;
    Vector2d start_N;
    double course_rad;
    double radius_m;
  };
  const CircleCase rows[] = {{"FromFarAway", {-600, 0}, 0, 80},
                             {"FromItsMiddle", {100.1, -50}, 1, 80},
                             {"Counterclockwise", {0, 300}, -2, -80},
                             {"TheWrongWayRound", {180, -50}, -M_PI / 2, 80}};
  for (const auto& test : rows) {
    SCOPED_TRACE(test.name);
    Flyer flyer{.p_N = test.start_N, .course_rad = test.course_rad};
    const CirclePath circle{.centre_N = {100, -50}, .radius_m = test.radius_m};
    flyer.fly(circle, {}, 120);
    const Vector2d from_middle = flyer.p_N - circle.centre_N;
    EXPECT_NEAR(from_middle.norm(), std::abs(test.radius_m), 0.05);
    const Vector2d v = flyer.v_N();
    const double turns_right = from_middle.x() * v.y() - from_middle.y() * v.x();
    EXPECT_GT(turns_right * test.radius_m, 0);
    // In the circle the acceleration is that of the circle.
    EXPECT_NEAR(path_acceleration_m_s2(circle, {}, flyer.p_N, v), 15.0 * 15.0 / test.radius_m,
                0.02);
  }
}

TEST(Line, IsMetAndFollowed) {
  const LinePath line{.from_N = {0, 0}, .to_N = {1000, 1000}};
  Flyer flyer{.p_N = {0, 200}, .course_rad = M_PI};
  flyer.fly(line, {}, 60);
  const Vector2d right(-std::sqrt(0.5), std::sqrt(0.5));
  EXPECT_NEAR(flyer.p_N.dot(right), 0, 0.05);
  EXPECT_NEAR(std::remainder(flyer.course_rad - M_PI / 4, 2 * M_PI), 0, 1e-3);
}

TEST(Line, TurnsTheVehicleThatFliesTheOtherWay) {
  const LinePath line{.from_N = {0, 0}, .to_N = {100, 0}};
  EXPECT_NE(path_acceleration_m_s2(line, {}, {50, 1}, {-15, 0}), 0);
}

TEST(Line, KnowsHowFarBeyondItsEndAPlaceIs) {
  const LinePath line{.from_N = {0, 0}, .to_N = {0, 100}};
  EXPECT_DOUBLE_EQ(line.beyond_m({7, 130}), 30);
  EXPECT_DOUBLE_EQ(line.beyond_m({7, 60}), -40);
}

}  // namespace
}  // namespace cas::fcu
