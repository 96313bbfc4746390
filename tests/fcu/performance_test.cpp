// SPDX-License-Identifier: BSD-3-Clause
// Performance of the controller in a small simulator of the tests' own: steps, tracking, poor
// lines. The figures that are published, wind and a thousand flights come from flight_figures.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tests/fcu/support/closed_loop.hpp"
#include "tests/fcu/support/flight_statistics.hpp"

namespace cas::fcu {
namespace {

using Eigen::Vector3d;
using test::ClosedLoop;
using test::FlightStatistics;
using test::LoopOptions;

LoopOptions rtk(std::uint64_t seed) {
  LoopOptions options;
  options.seed = seed;
  options.noise = test::rtk_noise();
  return options;
}

void hover_at_home(ClosedLoop& loop, double settle_s) {
  ASSERT_TRUE(loop.fly_to_hover(2.5));
  loop.keep_packets = false;
  loop.go_to(0, 0, 2.5, 0.0F);
  loop.run(settle_s);
}

TEST(Performance, RtkHoverKeepsItsPlace) {
  FlightStatistics pooled;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    ClosedLoop loop(rtk(seed));
    hover_at_home(loop, 20);
    loop.run(40, [&] { pooled.add(loop, {0, 0, -2.5}, 0); });
  }
  const FlightStatistics rms = pooled.rms();
  EXPECT_LE(rms.tracking_m[0], 0.02);
  EXPECT_LE(rms.tracking_m[1], 0.02);
  EXPECT_LE(rms.tracking_m[2], 0.045);
  EXPECT_LE(rms.yaw_rad, 0.034);
}

TEST(Performance, RtkStepOfAMetreSettlesInThreeSecondsWithLittleOvershoot) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ClosedLoop loop(rtk(seed));
    hover_at_home(loop, 8);
    ASSERT_TRUE(loop.fcu().set_param("CAS_TRJ_SIZE", 1));
    ASSERT_TRUE(loop.fcu().set_param("CAS_TRJ_PERIOD", 6));
    ASSERT_TRUE(loop.fcu().set_param("CAS_TRJ_SHAPE", 3));
    loop.run(6);
    const double start = loop.time_s();
    double settled = 0, highest = 0;
    loop.run(6, [&] {
      const double x = loop.truth().p_N.x();
      if (std::abs(x - 1) > 0.05) settled = loop.time_s() - start;
      highest = std::max(highest, x);
    });
    EXPECT_LE(settled, 3.0) << seed;
    EXPECT_LT(highest, 1.10) << seed;
    EXPECT_GT(highest, 0.95) << seed;
  }
}

TEST(Performance, RtkFigureEightAtTwoMetresPerSecondIsTracked) {
  ClosedLoop loop(rtk(1));
  hover_at_home(loop, 8);
  ASSERT_TRUE(loop.fcu().set_param("CAS_TRJ_SIZE", 4));
  ASSERT_TRUE(loop.fcu().set_param("CAS_TRJ_SPEED", 2));
  ASSERT_TRUE(loop.fcu().set_param("CAS_TRJ_SHAPE", 2));
  loop.run(8);
  double square = 0, fastest = 0;
  int n = 0;
  loop.run(40, [&] {
    square += (loop.truth().p_N - loop.fcu().status().reference_N).squaredNorm();
    fastest = std::max(fastest, loop.truth().v_N.norm());
    ++n;
  });
  EXPECT_LE(std::sqrt(square / n), 0.15);
  EXPECT_GT(fastest, 1.8);
}

TEST(OnAPoorLine, KeepsFlying) {
  struct PoorLine {
    const char* name;
    double sensor_loss;
    int delay_ms;
  };
  const PoorLine rows[] = {{"TenPercentLost", 0.1, 0}, {"TenMillisecondsEachWay", 0, 10}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    LoopOptions options;
    options.sensor_loss = row.sensor_loss;
    options.line.extra_delay = std::chrono::milliseconds(row.delay_ms);
    ClosedLoop loop(options);
    hover_at_home(loop, 10);
    double worst = 0;
    loop.run(60,
             [&] { worst = std::max(worst, (loop.truth().p_N - Vector3d(0, 0, -2.5)).norm()); });
    EXPECT_TRUE(loop.fcu().status().armed);
    EXPECT_LT(worst, 0.6);
  }
}

/// The delay is really in the loop: enough of it brings any attitude controller down.
TEST(Performance, AnAbsurdDelayDoesBringItDown) {
  LoopOptions options;
  options.line.extra_delay = std::chrono::milliseconds(80);
  ClosedLoop loop(options);
  loop.fly_to_hover(2.5);
  loop.run(20);
  EXPECT_TRUE(!loop.fcu().status().armed || loop.multirotor().on_ground() ||
              (loop.truth().p_N - Vector3d(0, 0, -2.5)).norm() > 1);
}

}  // namespace
}  // namespace cas::fcu
