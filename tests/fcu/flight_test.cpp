// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "base/earth/frames.hpp"
#include "fcu/flight_controller.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/fcu/support/closed_loop.hpp"
#include "tests/support/paths.hpp"

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

/// Ids of the packets that the controller answers each sensor message with, at 500 Hz for a second.
std::vector<std::vector<std::uint32_t>> answers(Pace pace) {
  std::vector<std::vector<std::uint32_t>> steps;
  FcuConfig config;
  config.vehicle =
      base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/iris_paper.yaml");
  config.pace = pace;
  FlightController fcu(config, [&](std::span<const std::uint8_t> bytes) {
    mav::PacketParser parser(mavlink::common::table());
    parser.feed(bytes,
                [&](const mav::PacketView& packet) { steps.back().push_back(packet.message_id); });
  });
  mav::PacketBuffer packet;
  for (std::uint64_t ms = 2; ms <= 1000; ms += 2) {
    mavlink::common::HilSensor sensor{.time_usec = 1000 * ms, .zacc = -9.81F};
    packet.size = mav::encode(sensor, {1, 200}, static_cast<std::uint8_t>(ms / 2), packet.bytes);
    steps.emplace_back();
    fcu.on_bytes(packet.view(), base::RunTime(std::chrono::milliseconds(ms)));
  }
  return steps;
}

// The simulator goes on with the controls; what comes after them meets its next message now here,
// now there.
TEST(Lockstep, ControlsAreTheLastWordInAStep) {
  std::size_t controls = 0;
  std::size_t others = 0;
  for (const auto& ids : answers(Pace::kLockstep)) {
    if (ids.empty()) continue;
    EXPECT_EQ(ids.back(), mavlink::common::HilControls::kId);
    ++controls;
    others += ids.size() - 1;
  }
  EXPECT_NEAR(static_cast<double>(controls), 400, 2);
  EXPECT_GT(others, 50U) << "there is telemetry";
}

TEST(RealTime, ControlsAreTheFirstWordInAStep) {
  std::size_t together = 0;
  for (const auto& ids : answers(Pace::kRealtime)) {
    const auto controls = std::ranges::find(ids, mavlink::common::HilControls::kId);
    if (controls == ids.end()) continue;
    EXPECT_EQ(controls, ids.begin());
    together += ids.size() > 1 ? 1 : 0;
  }
  EXPECT_GT(together, 20U) << "there is telemetry";
}

}  // namespace
}  // namespace cas::fcu
