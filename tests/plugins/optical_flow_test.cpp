// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/optical_flow/optical_flow_model.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "tests/plugins/statistics.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;

constexpr double kQuiet = 1e-8;

OpticalFlowParams params() {
  return {.rate_hz = 50,
          .stddev_rad_s = 1e-9,
          .min_m = 0.1,
          .max_m = 30,
          .most_rad_s = 7,
          .position_B_m = Vector3d::Zero()};
}

/// One sample of 20 ms.
FlowSample one_sample(const Vector3d& v_D, const Vector3d& w_D, std::optional<double> distance_m) {
  OpticalFlowModel camera(params(), 1);
  for (int i = 0; i < 20; ++i) camera.accumulate(v_D, w_D, distance_m, 1e-3);
  return camera.sample();
}

TEST(Flow, IsTheTurnThatThePictureShows) {
  struct FlowCase {
    const char* name;
    Vector3d v_D;
    Vector3d w_D;
    Eigen::Vector2d flow_rad_s;  // [MAVLink]: motion along +Dy is negative about Dx, along +Dx
                                 // positive about Dy; a turn counts as it is
  };
  const FlowCase rows[] = {{"Forward", {1, 0, 0}, {0, 0, 0}, {0, 0.5}},
                           {"Right", {0, 1, 0}, {0, 0, 0}, {-0.5, 0}},
                           {"Rolling", {0, 0, 0}, {0.3, 0, 0}, {0.3, 0}},
                           {"PitchingWhileMoving", {1, 0, 0}, {0, -0.2, 0}, {0, 0.3}}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const FlowSample sample = one_sample(row.v_D, row.w_D, 2.0);
    EXPECT_NEAR(sample.time_s, 0.02, kQuiet);
    EXPECT_TRUE(sample.flow_rad.isApprox(row.flow_rad_s * 0.02, kQuiet)) << sample.flow_rad;
    EXPECT_NEAR((sample.turn_rad - row.w_D * 0.02).norm(), 0, kQuiet);
    EXPECT_EQ(sample.quality, 255);
  }
}

TEST(OpticalFlow, SeesNothingWithoutGroundTooNearOrTooFast) {
  const Vector3d forward(1, 0, 0);
  for (const std::optional<double> distance_m :
       {std::optional<double>(), std::optional(0.05), std::optional(0.12)}) {
    const FlowSample sample = one_sample(forward, Vector3d::Zero(), distance_m);
    EXPECT_EQ(sample.quality, 0);
    EXPECT_EQ(sample.flow_rad.norm(), 0);
  }
  EXPECT_FALSE(one_sample(forward, Vector3d::Zero(), std::nullopt).distance_m);
}

TEST(OpticalFlow, QualityIsTheShareOfTimeThatWasFollowed) {
  OpticalFlowModel camera(params(), 1);
  for (int i = 0; i < 20; ++i) {
    camera.accumulate({1, 0, 0}, Vector3d::Zero(), i < 8 ? std::optional(2.0) : std::nullopt, 1e-3);
  }
  const FlowSample sample = camera.sample();
  EXPECT_EQ(sample.quality, 102);
  EXPECT_NEAR(sample.flow_rad.y(), 0.004, kQuiet);
}

TEST(OpticalFlow, NoiseHasItsDeviation) {
  OpticalFlowParams noisy = params();
  noisy.stddev_rad_s = 0.05;
  OpticalFlowModel camera(noisy, 1);
  test::Statistics rates;
  for (int i = 0; i < 20'000; ++i) {
    camera.accumulate(Vector3d::Zero(), Vector3d::Zero(), 2.0, 0.02);
    rates.add(camera.sample().flow_rad.x() / 0.02);
  }
  EXPECT_NEAR(rates.stddev(), 0.05, 0.05 * 0.02);  // 4 standard errors of 20,000 samples
}

}  // namespace
}  // namespace cas::sim
