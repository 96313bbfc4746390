// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/angles.hpp"
#include "libsim/api/beacon_source.hpp"
#include "plugins/landing_target/landing_target_model.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/statistics.hpp"
#include "tests/support/refusal.hpp"

namespace cas::sim {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::chrono::milliseconds;
using std::chrono::seconds;

LandingTargetParams quiet_camera() {
  return {.rate_hz = 50,
          .max_m = 20,
          .half_view_rad = Eigen::Vector2d(30, 20) * base::kRadPerDeg,
          .stddev_m = 0};
}

Quaterniond turned(double degrees, const Vector3d& axis) {
  return Quaterniond(Eigen::AngleAxisd(degrees * base::kRadPerDeg, axis));
}

const double kAt10Deg = 10 * std::tan(10 * base::kRadPerDeg);  // m off at 10 m of height
const double kFrom10Deg = 10 / std::cos(10 * base::kRadPerDeg);

TEST(Sight, HasAnglesToTheRightAndToTheBack) {
  /// A vehicle and a beacon at the origin of W.
  struct SightCase {
    const char* name;
    Vector3d p_W;  // of the vehicle
    Quaterniond q_WB;
    double across_deg;  // to the right
    double along_deg;   // to the back
    double distance_m;
  };
  const SightCase rows[] = {
      {"Below", {0, 0, 10}, Quaterniond::Identity(), 0, 0, 10},
      // B's x is forward, y left: a vehicle to the left of the beacon sees it on the right.
      {"OnTheRight", {0, kAt10Deg, 10}, Quaterniond::Identity(), 10, 0, kFrom10Deg},
      {"Ahead", {-kAt10Deg, 0, 10}, Quaterniond::Identity(), 0, -10, kFrom10Deg},
      {"AheadOfANoseToTheNorth",
       {0, -kAt10Deg, 10},
       turned(90, Vector3d::UnitZ()),
       0,
       -10,
       kFrom10Deg},
      // With its nose down the camera looks to the back, and what is below is ahead of that.
      {"NoseDown", {0, 0, 10}, turned(10, Vector3d::UnitY()), 0, -10, 10},
      {"RollToTheRight", {0, 0, 10}, turned(10, Vector3d::UnitX()), 10, 0, 10}};
  for (const auto& c : rows) {
    SCOPED_TRACE(c.name);
    LandingTargetModel camera(quiet_camera(), 1);
    BodyState vehicle{.p_WB = c.p_W, .q_WB = c.q_WB};
    const Vector3d p_S = camera.from_eye_S(vehicle, Vector3d::Zero());
    ASSERT_TRUE(camera.in_view(p_S));
    const LandingTargetSample sample = camera.sample({}, p_S, true);
    EXPECT_NEAR(sample.angles_rad.x(), c.across_deg * base::kRadPerDeg, 1e-12);
    EXPECT_NEAR(sample.angles_rad.y(), c.along_deg * base::kRadPerDeg, 1e-12);
    ASSERT_TRUE(sample.distance_m);
    EXPECT_NEAR(*sample.distance_m, c.distance_m, 1e-12);
  }
}

TEST(LandingTarget, SeesWhatIsInThePictureAndInRange) {
  LandingTargetParams params = quiet_camera();
  params.min_m = 0.5;
  const LandingTargetModel camera(params, 1);
  const auto at = [](double across_deg, double along_deg, double depth_m) {
    return Vector3d(-depth_m * std::tan(along_deg * base::kRadPerDeg),
                    -depth_m * std::tan(across_deg * base::kRadPerDeg), -depth_m);
  };
  EXPECT_TRUE(camera.in_view(at(29.9, 19.9, 5)));
  EXPECT_FALSE(camera.in_view(at(30.1, 0, 5)));
  EXPECT_FALSE(camera.in_view(at(-30.1, 0, 5)));
  EXPECT_FALSE(camera.in_view(at(0, 20.1, 5)));
  EXPECT_FALSE(camera.in_view(at(0, 0, 20.1)));
  EXPECT_FALSE(camera.in_view(at(0, 0, 0.4)));
  EXPECT_FALSE(camera.in_view({0, 0, 5})) << "above the camera";
}

TEST(LandingTarget, CaseAndPlaceOfTheCameraCount) {
  LandingTargetParams params = quiet_camera();
  params.position_B_m = {0.2, -0.1, -0.05};
  params.q_BS = turned(90, Vector3d::UnitZ());  // its x to the left of the vehicle
  const LandingTargetModel camera(params, 1);
  BodyState vehicle{.p_WB = {0, 0, 3.05}};
  const Vector3d p_S = camera.from_eye_S(vehicle, {1.2, -0.1, 0});  // 1 m ahead of the camera
  EXPECT_TRUE(p_S.isApprox(Vector3d(0, -1, -3), 1e-12)) << p_S.transpose();
}

TEST(LandingTarget, NoiseHasItsDeviations) {
  LandingTargetParams params = quiet_camera();
  params.stddev_rad = 0.01;
  params.stddev_m = 0.2;
  LandingTargetModel camera(params, 1);
  test::Statistics across, along, distance;
  for (int i = 0; i < 20'000; ++i) {
    const LandingTargetSample sample = camera.sample({}, {0, 0, -10}, true);
    across.add(sample.angles_rad.x());
    along.add(sample.angles_rad.y());
    distance.add(*sample.distance_m);
  }
  constexpr double kShare = 0.02;  // 4 standard errors of 20,000 samples
  EXPECT_NEAR(across.stddev(), 0.01, 0.01 * kShare);
  EXPECT_NEAR(along.stddev(), 0.01, 0.01 * kShare);
  EXPECT_NEAR(distance.stddev(), 0.2, 0.2 * kShare);
}

constexpr const char* kCameraKeys =
    "beacon: pad, rate_hz: 50, max_m: 20, view_across_deg: 60, view_along_deg: 40, stddev_deg: 0.1";

/// The plugin above a beacon that the test places; the ground is the plane z = 0.
class LandingTargetPlugin : public testing::Test {
 protected:
  void add(const std::string& more) {
    harness_.add("landing_target", std::string("{") + kCameraKeys + more + "}");
    subscription_ = harness_.bus.subscribe<LandingTargetSample>(
        "iris0/landing_target", [this](const LandingTargetSample& s) { samples_.push_back(s); });
    beacon_.publish({[this](base::SimTime time) {
      return Vector3d(beacon_W_ + base::to_seconds(time) * beacon_v_W_);
    }});
    harness_.world.body.p_WB = {0, 0, 10};
  }

  test::PluginHarness harness_;
  Publisher<BeaconSource> beacon_ = harness_.bus.advertise<BeaconSource>("beacon/pad");
  Subscription subscription_;
  std::vector<LandingTargetSample> samples_;
  Vector3d beacon_W_ = Vector3d::Zero();
  Vector3d beacon_v_W_ = Vector3d::Zero();
};

TEST_F(LandingTargetPlugin, TakesFiftyPicturesASecondAndTheSameAfterAReset) {
  add("");
  harness_.run(seconds(2));
  ASSERT_EQ(samples_.size(), 100U);
  EXPECT_EQ(samples_[0].time, base::SimTime(milliseconds(20)));
  EXPECT_TRUE(samples_[99].seen);
  EXPECT_FALSE(samples_[99].distance_m) << "it is not measured";
  const std::vector<LandingTargetSample> first = samples_;
  samples_.clear();
  harness_.reset();
  harness_.run(seconds(2));
  ASSERT_EQ(samples_.size(), 100U);
  EXPECT_EQ(samples_[57].angles_rad, first[57].angles_rad);
}

TEST_F(LandingTargetPlugin, DelayHoldsAPictureBackWithItsOwnStamp) {
  add(", delay_s: 0.11");
  harness_.run(milliseconds(129));
  EXPECT_TRUE(samples_.empty());
  harness_.run(milliseconds(1));
  ASSERT_EQ(samples_.size(), 1U);
  EXPECT_EQ(samples_[0].time, base::SimTime(milliseconds(20)));
  harness_.run(milliseconds(870));
  EXPECT_EQ(samples_.size(), 44U) << "those up to 0.88 s";
}

TEST_F(LandingTargetPlugin, SurfacesHideTheBeaconButNotThoseUnderIt) {
  add("");
  beacon_W_.z() = -0.04;  // below the ground, within 5 cm
  harness_.run(milliseconds(20));
  beacon_W_.z() = -0.3;
  harness_.run(milliseconds(20));
  ASSERT_EQ(samples_.size(), 2U);
  EXPECT_TRUE(samples_[0].seen);
  EXPECT_FALSE(samples_[1].seen);
}

TEST_F(LandingTargetPlugin, FollowsABeaconThatMoves) {
  add("");
  beacon_v_W_ = {0, -1, 0};  // to the right of the vehicle
  harness_.run(seconds(1));
  EXPECT_NEAR(samples_.back().angles_rad.x(), std::atan(0.1), 0.01);  // 5 deviations
}

TEST(LandingTargetKeys, SayWhatIsWrong) {
  const auto refused = [](const std::string& yaml) {
    test::PluginHarness harness;
    const auto beacon = harness.bus.advertise<BeaconSource>("beacon/pad");
    return cas::test::refusal([&] { harness.add("landing_target", yaml); });
  };
  const std::string view = "rate_hz: 50, max_m: 20, view_along_deg: 40";
  EXPECT_NE(refused("{beacon: mat, " + view + ", view_across_deg: 60}").find("no beacon of this"),
            std::string::npos);
  EXPECT_NE(refused("{beacon: pad, " + view + "}").find("view_across_deg"), std::string::npos);
  EXPECT_NE(
      refused("{beacon: pad, " + view + ", view_across_deg: 200}").find("must lie in [1, 170]"),
      std::string::npos);
}

}  // namespace
}  // namespace cas::sim
