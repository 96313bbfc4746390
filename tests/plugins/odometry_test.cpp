// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "base/angles.hpp"
#include "base/earth/frames.hpp"
#include "libsim/api/odometry_sample.hpp"
#include "plugins/odometry/odometry_messages.hpp"
#include "plugins/odometry/odometry_model.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/statistics.hpp"
#include "tests/support/refusal.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;
using Eigen::Vector3d;
using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr double kOdometryQuiet = 1e-8;
constexpr double kOdometryStep_s = 1e-3;

/// Without errors but for `keys`.
std::string quiet_odometry(const std::string& keys) {
  std::string text = "{rate_hz: 50";
  for (const char* noise :
       {"position_stddev_m", "attitude_stddev_deg", "velocity_stddev_m_s", "rate_stddev_deg_s"}) {
    if (keys.find(noise) == std::string::npos) text += ", " + std::string(noise) + ": 1e-9";
  }
  return text + (keys.empty() ? "" : ", " + keys) + "}";
}

OdometryParams odometry_params(const std::string& keys) {
  const auto node = base::ConfigNode::parse(quiet_odometry(keys));
  OdometryParams result = parse_odometry_params(node, kOdometryStep_s);
  node.reject_unused();
  return result;
}

// The frame.

TEST(OdometryFrameOf, TurnsAndShiftsPlaceAndHeadingAlone) {
  struct OdometryFrameCase {
    const char* name;
    const char* keys;
    Vector3d position_F_m;  // of a vehicle 3 m north, 4 m east, 5 m up
    double yaw_deg;         // of one that heads 30 deg
  };
  const OdometryFrameCase rows[] = {
      {"Default", "", {3, 4, -5}, 30},
      {"Origin", "origin_N_m: [1, 1, 2]", {2, 3, -7}, 30},
      {"HeadingEast", "heading_deg: 90", {4, -3, -5}, -60},
      {"Both", "heading_deg: 180, origin_N_m: [1, 0, 0]", {-2, -4, -5}, -150}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    OdometryModel model(odometry_params(row.keys), 1);
    const OdometryTruth truth{.p_N = {3, 4, -5},
                              .q_ND = base::quaternion_rpy(0.1, -0.2, base::radians(30)),
                              .v_D = {1, 2, 3},
                              .w_D = {0.1, 0.2, 0.3}};
    const OdometrySample sample = model.sample({}, truth);
    EXPECT_NEAR((sample.position_F_m - row.position_F_m).norm(), 0, kOdometryQuiet)
        << sample.position_F_m;
    const Vector3d rpy = base::euler_rpy(sample.q_FD);
    EXPECT_NEAR(rpy.x(), 0.1, kOdometryQuiet);
    EXPECT_NEAR(rpy.y(), -0.2, kOdometryQuiet);
    EXPECT_NEAR(base::degrees(rpy.z()), row.yaw_deg, 1e-6);
    EXPECT_NEAR((sample.velocity_D_m_s - truth.v_D).norm(), 0, kOdometryQuiet);
    EXPECT_NEAR((sample.rate_D_rad_s - truth.w_D).norm(), 0, kOdometryQuiet);
  }
}

// Errors.

TEST(Odometry, WhiteNoiseHasItsDeviationOnEachAxis) {
  OdometryModel model(
      odometry_params("position_stddev_m: [0.1, 0.2, 0.3], attitude_stddev_deg: [1, 2, 3], "
                      "velocity_stddev_m_s: 0.5, rate_stddev_deg_s: 4"),
      1);
  constexpr int kSamples = 20'000;
  constexpr double kShare = 0.02;  // 4 standard errors of 20,000 samples
  test::Statistics position[3], attitude[3], velocity, rate;
  for (int i = 0; i < kSamples; ++i) {
    const OdometrySample sample = model.sample({}, {});
    const Vector3d rpy = base::euler_rpy(sample.q_FD);
    for (int axis = 0; axis < 3; ++axis) {
      position[axis].add(sample.position_F_m[axis]);
      attitude[axis].add(base::degrees(rpy[axis]));
    }
    velocity.add(sample.velocity_D_m_s.y());
    rate.add(base::degrees(sample.rate_D_rad_s.z()));
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(position[axis].stddev() / (0.1 * (axis + 1)), 1, kShare) << axis;
    EXPECT_NEAR(attitude[axis].stddev() / (axis + 1), 1, kShare) << axis;
    EXPECT_NEAR(position[axis].mean(), 0, 4 * 0.1 * (axis + 1) / std::sqrt(kSamples)) << axis;
  }
  EXPECT_NEAR(velocity.stddev() / 0.5, 1, kShare);
  EXPECT_NEAR(rate.stddev() / 4, 1, kShare);
}

/// White noise of a density N has the Allan deviation N / sqrt(tau).
TEST(Odometry, ADensityOfNoiseHoldsAtAnyRate) {
  for (const char* rate : {"20", "200"}) {
    const auto node = base::ConfigNode::parse(
        "{rate_hz: " + std::string(rate) +
        ", position_density_m_per_sqrt_hz: 0.02, attitude_stddev_deg: 1e-9, "
        "velocity_stddev_m_s: 1e-9, rate_stddev_deg_s: 1e-9}");
    OdometryModel model(parse_odometry_params(node, kOdometryStep_s), 3);
    const double dt_s = 1 / std::stod(rate);
    std::vector<double> north;
    for (int i = 0; i < 40'000; ++i) north.push_back(model.sample({}, {}).position_F_m.x());
    const auto m = static_cast<std::size_t>(std::lround(0.5 / dt_s));
    EXPECT_NEAR(test::allan_deviation(north, dt_s, m) * std::sqrt(0.5) / 0.02, 1, 0.1) << rate;
  }
}

/// Of many runs of 10 s at each of two rates: the deviation at the end is walk * sqrt(time).
TEST(Odometry, DriftIsARandomWalkOfPositionAndHeading) {
  constexpr int kRuns = 2000;
  constexpr double kShare = 0.064;  // 4 standard errors of 2000 runs
  for (const int rate_hz : {10, 50}) {
    OdometryParams drifting = odometry_params(
        "position_walk_m_per_sqrt_s: [0.1, 0.2, 0.3], yaw_walk_deg_per_sqrt_s: 0.5");
    drifting.rate_hz = rate_hz;
    test::Statistics position[3], yaw, half;
    for (int run = 0; run < kRuns; ++run) {
      OdometryModel model(drifting, static_cast<std::uint64_t>(run + 1));
      OdometrySample sample;
      for (int i = 0; i < 10 * rate_hz; ++i) {
        sample = model.sample({}, {});
        if (i + 1 == 5 * rate_hz) half.add(sample.position_F_m.x());
      }
      for (int axis = 0; axis < 3; ++axis) position[axis].add(sample.position_F_m[axis]);
      yaw.add(base::degrees(base::euler_rpy(sample.q_FD).z()));
    }
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(position[axis].stddev() / (0.1 * (axis + 1) * std::sqrt(10)), 1, kShare);
    }
    EXPECT_NEAR(yaw.stddev() / (0.5 * std::sqrt(10)), 1, kShare);
    EXPECT_NEAR(half.stddev() / (0.1 * std::sqrt(5)), 1, kShare);
  }
}

TEST(Odometry, ADriftOfTheHeadingTurnsWhatIsFlownAndMovesNothing) {
  OdometryModel model(odometry_params("yaw_walk_deg_per_sqrt_s: 5"), 1);
  const Vector3d far(100, 50, -3);
  OdometrySample before;
  for (int i = 0; i < 200; ++i) before = model.sample({}, {.p_N = far});
  EXPECT_NEAR((before.position_F_m - far).norm(), 0, 1e-6);
  const double yaw = base::euler_rpy(before.q_FD).z();
  ASSERT_GT(std::abs(yaw), base::radians(1));
  // A metre until the next sample counts by the heading of the one before.
  const OdometrySample after = model.sample({}, {.p_N = far + Vector3d::UnitX()});
  const Vector3d flown = after.position_F_m - before.position_F_m;
  EXPECT_NEAR(flown.norm(), 1, 1e-6);
  EXPECT_NEAR(std::atan2(flown.y(), flown.x()), yaw, 1e-6);
}

// The plugin.

/// A vehicle with odometry, and what it publishes.
class OdometryUnit {
 public:
  explicit OdometryUnit(const std::string& keys, const std::string& faults = {}) {
    harness_.add("odometry", quiet_odometry(keys));
    if (!faults.empty()) harness_.add("fault", "{faults: [" + faults + "]}");
    listening_ = harness_.bus.subscribe<OdometrySample>("iris0/odometry",
                                                        [this](const OdometrySample& sample) {
                                                          samples.push_back(sample);
                                                          heard.push_back(now_);
                                                        });
  }

  /// One step of a millisecond.
  void step() {
    now_ += milliseconds(1);
    harness_.step();
  }
  void run(base::Duration time) {
    for (base::Duration done{}; done < time; done += milliseconds(1)) step();
  }
  void reset() {
    harness_.reset();
    samples.clear();
    heard.clear();
    now_ = {};
  }
  BodyState& body() { return harness_.world.body; }

  std::vector<OdometrySample> samples;
  std::vector<base::SimTime> heard;

 private:
  test::PluginHarness harness_;
  Subscription listening_;
  base::SimTime now_{};
};

TEST(OdometryPlugin, DelaysEachSampleByTheSameTimeAndKeepsItsStamp) {
  OdometryUnit unit("delay_s: 0.037");
  unit.run(milliseconds(1000));
  ASSERT_EQ(unit.samples.size(), 48U);  // the one of 0.98 s comes at 1.017 s
  for (std::size_t i = 0; i < unit.samples.size(); ++i) {
    EXPECT_EQ(unit.samples[i].time.time_since_epoch(), milliseconds(20 * (i + 1))) << i;
    EXPECT_EQ(unit.heard[i] - unit.samples[i].time, milliseconds(37)) << i;
  }
}

TEST(OdometryPlugin, MeasuresAtItsOwnPointOfTheVehicle) {
  OdometryUnit unit("position_B_m: [1, 0, 0.5]");
  BodyState& body = unit.body();
  body.p_WB = {10, 20, 30};  // east, north, up
  body.q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0, 0, base::radians(90)));
  body.v_WB = {2, 0, 0};  // east: forward
  body.w_WB_B = {0, 0, 0.5};
  unit.run(milliseconds(20));
  ASSERT_EQ(unit.samples.size(), 1U);
  const OdometrySample& sample = unit.samples.front();
  EXPECT_NEAR((sample.position_F_m - Vector3d(20, 11, -30.5)).norm(), 0, kOdometryQuiet);
  EXPECT_NEAR((sample.velocity_D_m_s - Vector3d(2, -0.5, 0)).norm(), 0, kOdometryQuiet);
  EXPECT_NEAR((sample.rate_D_rad_s - Vector3d(0, 0, -0.5)).norm(), 0, kOdometryQuiet);
}

TEST(OdometryPlugin, BeginsAnewWithTheSameSamples) {
  OdometryUnit unit(
      "position_stddev_m: 0.1, position_walk_m_per_sqrt_s: 0.1, yaw_walk_deg_per_sqrt_s: 1");
  unit.run(milliseconds(500));
  const std::vector<OdometrySample> first = unit.samples;
  unit.reset();
  unit.run(milliseconds(500));
  ASSERT_EQ(unit.samples.size(), first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(unit.samples[i].position_F_m, first[i].position_F_m);
    EXPECT_EQ(unit.samples[i].q_FD.coeffs(), first[i].q_FD.coeffs());
  }
}

// Faults.

TEST(OdometryFaults, ARelocatedFrameTurnsAboutTheVehicleAndIsCounted) {
  OdometryUnit unit("", "{at_s: 0.1, for_s: 0.2, relocated: {position_m: [2, 0, 0], yaw_deg: 90}}");
  unit.body().p_WB = {0, 5, 1};  // 5 m north
  unit.run(milliseconds(100));
  EXPECT_EQ(unit.samples.back().reset_counter, 0);
  unit.run(milliseconds(100));
  EXPECT_EQ(unit.samples.back().reset_counter, 1);
  EXPECT_NEAR((unit.samples.back().position_F_m - Vector3d(7, 0, -1)).norm(), 0, kOdometryQuiet);
  const double yaw_before = base::euler_rpy(unit.samples.front().q_FD).z();
  EXPECT_NEAR(base::wrap_angle(base::euler_rpy(unit.samples.back().q_FD).z() - yaw_before),
              base::radians(90), kOdometryQuiet);
  unit.body().p_WB = {0, 6, 1};  // a metre north is a metre along y by now
  unit.run(milliseconds(60));
  EXPECT_NEAR((unit.samples.back().position_F_m - Vector3d(7, 1, -1)).norm(), 0, kOdometryQuiet);
  unit.run(milliseconds(100));
  EXPECT_EQ(unit.samples.back().reset_counter, 2);
  EXPECT_NEAR((unit.samples.back().position_F_m - Vector3d(6, 0, -1)).norm(), 0, kOdometryQuiet);
}

TEST(OdometryFault, ChangesWhatIsPublished) {
  struct OdometryFaultCase {
    const char* fault;      // from 0.1 s on
    Vector3d position_F_m;  // at 1 s, of a vehicle that flies north at 1 m/s and up there 1 m
    int quality;
    std::size_t samples;  // in 1 s
  };
  const OdometryFaultCase rows[] = {
      {"drop: odometry", {0.1, 0, -1}, 80, 5},
      {"blind: odometry", {1, 0, -1}, -1, 50},
      {"bias: {sensor: odometry, position_m: [2, 0, 0]}", {3, 0, -1}, 80, 50},
      {"drift: {sensor: odometry, position_m_s: [0, 2, 0]}", {1, 1.8, -1}, 80, 50},
      {"freeze: odometry", {0.1, 0, -1}, 80, 50},
      {"delay: {sensor: odometry, by_s: 0.3}", {0.7, 0, -1}, 80, 35}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.fault);
    OdometryUnit unit("quality: 80", "{at_s: 0.1, " + std::string(row.fault) + "}");
    for (int i = 1; i <= 1000; ++i) {
      unit.body().p_WB = {0, 1e-3 * i, 1};
      unit.step();
    }
    ASSERT_EQ(unit.samples.size(), row.samples);
    const OdometrySample& last = unit.samples.back();
    constexpr double kOneStep_m = 3e-3;  // a fault begins with the step after its time
    EXPECT_NEAR((last.position_F_m - row.position_F_m).norm(), 0, kOneStep_m) << last.position_F_m;
    EXPECT_EQ(last.quality, row.quality);
    EXPECT_EQ(last.reset_counter, 0);
  }
}

TEST(OdometryFaults, ATurnOfTheAttitudeLeavesThePosition) {
  OdometryUnit unit("", "{at_s: 0, bias: {sensor: odometry, attitude_deg: [0, 0, 20]}}");
  unit.body().p_WB = {1, 2, 3};
  unit.body().q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0.1, 0.2, base::radians(15)));
  unit.run(milliseconds(40));
  const Vector3d rpy = base::euler_rpy(unit.samples.back().q_FD);
  EXPECT_NEAR(base::degrees(rpy.z()), 35, 1e-6);
  EXPECT_NEAR(rpy.x(), 0.1, kOdometryQuiet);
  EXPECT_NEAR((unit.samples.back().position_F_m - Vector3d(2, 1, -3)).norm(), 0, kOdometryQuiet);
}

// Messages.

OdometrySample flown_sample() {
  return {.time = base::SimTime(milliseconds(1234)),
          .position_F_m = {1, 2, -3},
          .q_FD = base::quaternion_rpy(0.1, 0.2, 0.3),
          .velocity_D_m_s = {4, 5, 6},
          .rate_D_rad_s = {0.4, 0.5, 0.6},
          .reset_counter = 7,
          .quality = 55};
}

constexpr const char* kNoisyKeys =
    "position_stddev_m: [0.1, 0.2, 0.3], attitude_stddev_deg: [1, 2, 3], "
    "velocity_stddev_m_s: [0.4, 0.5, 0.6], rate_stddev_deg_s: [4, 5, 6]";

/// Variances on the diagonal of the upper right half, and nothing beside it.
void expect_variances(const std::array<float, 21>& covariance, const Vector3d& first,
                      const Vector3d& second) {
  std::array<double, 21> expected{};
  expected[0] = first.x() * first.x();
  expected[6] = first.y() * first.y();
  expected[11] = first.z() * first.z();
  expected[15] = second.x() * second.x();
  expected[18] = second.y() * second.y();
  expected[20] = second.z() * second.z();
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(covariance[i]), expected[i], 1e-7) << i;
  }
}

TEST(OdometryMessages, OdometryHasFramesCovariancesAndCounters) {
  const OdometryParams unit = odometry_params(std::string(kNoisyKeys) + ", estimator_type: MOCAP");
  const mv::Odometry message = to_odometry(flown_sample(), unit);
  EXPECT_EQ(message.time_usec, 1'234'000U);
  EXPECT_EQ(message.frame_id, mv::MavFrame::kLocalFrd);
  EXPECT_EQ(message.child_frame_id, mv::MavFrame::kBodyFrd);
  EXPECT_EQ(message.estimator_type, mv::MavEstimatorType::kMocap);
  EXPECT_EQ(Vector3d(message.x, message.y, message.z), Vector3d(1, 2, -3));
  EXPECT_EQ(Vector3d(message.vx, message.vy, message.vz), Vector3d(4, 5, 6));
  EXPECT_NEAR(static_cast<double>(message.yawspeed), 0.6, 1e-6);
  const Eigen::Quaterniond q(static_cast<double>(message.q[0]), static_cast<double>(message.q[1]),
                             static_cast<double>(message.q[2]), static_cast<double>(message.q[3]));
  EXPECT_LT(q.angularDistance(flown_sample().q_FD), 1e-3);
  EXPECT_EQ(message.reset_counter, 7);
  EXPECT_EQ(message.quality, 55);
  const Vector3d attitude = Vector3d(1, 2, 3) * base::kRadPerDeg;
  expect_variances(message.pose_covariance, {0.1, 0.2, 0.3}, attitude);
  expect_variances(message.velocity_covariance, {0.4, 0.5, 0.6},
                   Vector3d(4, 5, 6) * base::kRadPerDeg);
}

TEST(OdometryMessages, TheFrameIsCalledAsConfigured) {
  EXPECT_EQ(to_odometry({}, odometry_params("frame: LOCAL_NED, heading_deg: 20")).frame_id,
            mv::MavFrame::kLocalNed);
}

TEST(OdometryMessages, TheKindsHaveTheNumbersOfMavlink) {
  const auto type = [](const char* word) {
    return to_odometry({}, odometry_params("estimator_type: " + std::string(word))).estimator_type;
  };
  EXPECT_EQ(type("VIO"), mv::MavEstimatorType::kVio);
  EXPECT_EQ(type("VISION"), mv::MavEstimatorType::kVision);
  EXPECT_EQ(type("LIDAR"), mv::MavEstimatorType::kLidar);
  EXPECT_EQ(type("NAIVE"), mv::MavEstimatorType::kNaive);
  EXPECT_EQ(type("UNKNOWN"), mv::MavEstimatorType::kUnknown);
}

TEST(OdometryMessages, VisionPositionEstimateHasThePoseAlone) {
  const auto message = to_vision_position_estimate(
      flown_sample(),
      odometry_params(std::string(kNoisyKeys) + ", message: VISION_POSITION_ESTIMATE"));
  EXPECT_EQ(message.usec, 1'234'000U);
  EXPECT_EQ(Vector3d(message.x, message.y, message.z), Vector3d(1, 2, -3));
  EXPECT_NEAR(static_cast<double>(message.roll), 0.1, 1e-6);
  EXPECT_NEAR(static_cast<double>(message.pitch), 0.2, 1e-6);
  EXPECT_NEAR(static_cast<double>(message.yaw), 0.3, 1e-6);
  EXPECT_EQ(message.reset_counter, 7);
  expect_variances(message.covariance, {0.1, 0.2, 0.3}, Vector3d(1, 2, 3) * base::kRadPerDeg);
}

// Bad input.

TEST(OdometryRefuses, WithASentenceThatNamesTheKey) {
  struct RefusedOdometry {
    const char* keys;
    const char* says;
  };
  const RefusedOdometry rows[] = {
      {"message: GPS_INPUT", "message: 'GPS_INPUT' is none of"},
      {"estimator_type: GPS", "estimator_type: 'GPS' is none of"},
      {"message: VISION_POSITION_ESTIMATE, frame: LOCAL_NED",
       "frame: has no field in VISION_POSITION_ESTIMATE"},
      {"message: VISION_POSITION_ESTIMATE, quality: 50",
       "quality: has no field in VISION_POSITION_ESTIMATE"},
      {"quality: 101", "quality"},
      {"delay_s: -0.1", "delay_s"},
      {"yaw_walk_deg_per_sqrt_s: -1", "yaw_walk_deg_per_sqrt_s: must not be negative"},
      {"position_stddev_m: 0", "position_stddev_m: must be above zero"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.keys);
    EXPECT_THAT(test::refusal([&] { odometry_params(row.keys); }), HasSubstr(row.says));
  }
}

TEST(OdometryRefusals, NeedEachNoiseAndARateBelowTheSimulations) {
  const auto said = [](const std::string& text) {
    return test::refusal(
        [&] { parse_odometry_params(base::ConfigNode::parse(text), kOdometryStep_s); });
  };
  EXPECT_THAT(said("{rate_hz: 50, position_stddev_m: 1, attitude_stddev_deg: 1, "
                   "rate_stddev_deg_s: 1}"),
              HasSubstr("needs velocity_stddev_m_s or velocity_density_m_s_per_sqrt_hz"));
  EXPECT_THAT(said("{rate_hz: 2000, position_stddev_m: 1, attitude_stddev_deg: 1, "
                   "velocity_stddev_m_s: 1, rate_stddev_deg_s: 1}"),
              HasSubstr("rate_hz: exceeds the simulation's own rate"));
}

}  // namespace
}  // namespace cas::sim
