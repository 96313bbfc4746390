// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "base/earth/frames.hpp"
#include "tests/fcu/support/closed_loop.hpp"

namespace cas::fcu {
namespace {

using test::ClosedLoop;
using test::LoopOptions;

struct Rms {
  double x = 0, y = 0, z = 0, yaw = 0, ex = 0, ey = 0, ez = 0, eyaw = 0;
  int n = 0;
  void add(ClosedLoop& loop, const Eigen::Vector3d& reference_N, double yaw_reference) {
    const auto& t = loop.truth();
    const Eigen::Vector3d e = t.p_N - reference_N;
    const Eigen::Vector3d est = loop.fcu().status().p_N - t.p_N;
    x += e.x() * e.x();
    y += e.y() * e.y();
    z += e.z() * e.z();
    ex += est.x() * est.x();
    ey += est.y() * est.y();
    ez += est.z() * est.z();
    const double dyaw = base::wrap_angle(loop.yaw() - yaw_reference);
    const double dest =
        base::wrap_angle(base::euler_rpy(loop.fcu().status().q_ND).z() - loop.yaw());
    yaw += dyaw * dyaw;
    eyaw += dest * dest;
    ++n;
  }
  void finish() {
    for (double* v : {&x, &y, &z, &yaw, &ex, &ey, &ez, &eyaw}) *v = std::sqrt(*v / n);
  }
};

TEST(Flight, HoversWithTable1Noise) {
  LoopOptions options;
  ClosedLoop loop(options);
  ASSERT_TRUE(loop.fly_to_hover(2.5));
  loop.go_to(0, 0, 2.5, 0.0F);
  loop.run(5);
  Rms rms;
  loop.run(30, [&] { rms.add(loop, {0, 0, -2.5}, 0); });
  rms.finish();
  std::printf("rms x %.4f y %.4f z %.4f yaw %.4f | estimate x %.4f y %.4f z %.4f yaw %.4f\n", rms.x,
              rms.y, rms.z, rms.yaw, rms.ex, rms.ey, rms.ez, rms.eyaw);
  EXPECT_LE(rms.x, 0.25);
  EXPECT_LE(rms.y, 0.25);
  EXPECT_LE(rms.z, 0.15);
  EXPECT_LE(rms.yaw, 0.05);
}

TEST(Flight, TakesOffAndLandsAndDisarms) {
  ClosedLoop loop(LoopOptions{});
  ASSERT_TRUE(loop.fly_to_hover(2.5));
  loop.run(3);
  EXPECT_EQ(loop.command(mavlink::common::MavCmd::kNavLand), mavlink::common::MavResult::kAccepted);
  EXPECT_TRUE(loop.run_until([&] { return !loop.fcu().status().armed; }, 20));
  EXPECT_TRUE(loop.multirotor().on_ground());
  EXPECT_TRUE(loop.said("Landed"));
  for (const auto& t : loop.texts()) std::printf("%s\n", t.c_str());
}

}  // namespace
}  // namespace cas::fcu
