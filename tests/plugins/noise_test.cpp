// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/config/sensor_set.hpp"
#include "plugins/barometer/barometer_model.hpp"
#include "plugins/common/gauss_markov.hpp"
#include "plugins/common/noise_params.hpp"
#include "plugins/gps/gps_model.hpp"
#include "plugins/imu/imu_model.hpp"
#include "plugins/magnetometer/magnetometer_model.hpp"
#include "plugins/rangefinder/rangefinder_model.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/statistics.hpp"
#include "tests/support/paths.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;
using test::allan_deviation;
using test::kGravity;
using test::Statistics;

using Vector1d = Eigen::Matrix<double, 1, 1>;

Vector1d one(double value) { return Vector1d::Constant(value); }

TEST(GaussMarkov, StandsAtItsDeviationAtAnyStep) {
  for (const double dt : {0.0005, 0.01, 0.5, 5.0, 50.0}) {
    base::NormalRandom random(3);
    GaussMarkov<1> process(GaussMarkovParams<1>::standing(one(2.0), 1.0), dt);
    process.settle(random);
    Statistics values;
    const int count = dt < 0.1 ? 2'000'000 : 200'000;
    for (int i = 0; i < count; ++i) values.add(process.advance(random)[0]);
    const double independent = std::max(count * dt / 2.0, 100.0);
    const double limit = dt < 0.1 ? 4.0 / std::sqrt(2.0 * independent) : 0.02;
    EXPECT_NEAR(values.stddev() / 2.0, 1.0, limit) << dt;
  }
}

TEST(GaussMarkov, ForgetsWithItsTimeConstantWhateverTheStep) {
  for (const int steps : {1, 4, 100}) {  // of one time constant
    base::NormalRandom random(5);
    GaussMarkov<1> process(GaussMarkovParams<1>::standing(one(1.0), 2.0), 2.0 / steps);
    process.settle(random);
    double sum = 0;
    constexpr int kPairs = 40'000;
    double before = process.value()[0];
    for (int i = 0; i < kPairs; ++i) {
      for (int k = 0; k < steps; ++k) process.advance(random);
      sum += before * process.value()[0];
      before = process.value()[0];
    }
    EXPECT_NEAR(sum / kPairs, std::exp(-1.0), 0.02) << steps;  // 4 standard errors
  }
}

TEST(GaussMarkov, WithoutTimeConstantIsARandomWalk) {
  Statistics ends;
  base::NormalRandom random(9);
  for (int run = 0; run < 4000; ++run) {
    GaussMarkov<1> walk({one(0.5), 0.0}, 0.25);
    for (int i = 0; i < 64; ++i) walk.advance(random);  // 16 s: 0.5 * sqrt(16)
    ends.add(walk.value()[0]);
  }
  EXPECT_NEAR(ends.stddev(), 2.0, 0.1);
}

/// One axis of an IMU at rest, an hour at 100 Hz.
std::vector<double> static_gyro(const std::string& noise, std::uint64_t seed) {
  const auto node =
      base::ConfigNode::parse("{rate_hz: 100, accel_stddev_m_s2: 0.1, " + noise + "}");
  ImuModel imu(parse_imu_params(node, 1e-3), seed);
  std::vector<double> samples;
  constexpr int kHour = 360'000;
  samples.reserve(kHour);
  for (int i = 0; i < kHour; ++i) {
    imu.accumulate({}, {0, 0, -kGravity}, 0.01);
    samples.push_back(imu.sample({}, {}).angular_rate_B.x() * 180.0 / M_PI);
  }
  return samples;
}

TEST(Allan, GivesBackTheConfiguredDensity) {
  const auto samples = static_gyro("gyro_density_deg_s_per_sqrt_hz: 0.02", 1);
  EXPECT_NEAR(allan_deviation(samples, 0.01, 100) / 0.02, 1.0, 0.05);                     // at 1 s
  EXPECT_NEAR(allan_deviation(samples, 0.01, 1000) * std::sqrt(10.0) / 0.02, 1.0, 0.05);  // 10 s
}

TEST(Allan, GivesBackTheConfiguredBiasWalk) {
  // With density N and walk K: sigma^2(tau) = N^2 / tau + K^2 tau / 3.
  constexpr double kWalk = 0.02;
  double sum = 0;
  constexpr int kRuns = 5;  // one hour has too few stretches of 100 s for 5 %
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const auto samples = static_gyro(
        "gyro_density_deg_s_per_sqrt_hz: 0.001, gyro_bias_walk_deg_s_per_sqrt_s: 0.02, "
        "gyro_bias_time_constant_s: 0",
        seed);
    const double sigma = allan_deviation(samples, 0.01, 3000);
    sum += (sigma * sigma - 0.001 * 0.001 / 30.0) / 30.0 * 3.0;
  }
  EXPECT_NEAR(std::sqrt(sum / kRuns) / kWalk, 1.0, 0.05);
}

/// Deviation and mean of each sensor in 100 s at rest, by the simulation's step.
struct RestStatistics {
  Statistics gyro, accel, north, climb, field, pressure, range;
};

RestStatistics at_rest(base::Duration step) {
  test::PluginHarness harness(step);
  harness.world.body.p_WB.z() = 5;
  harness.add("imu",
              "{rate_hz: 250, gyro_density_deg_s_per_sqrt_hz: 0.05, gyro_drift_stddev_deg_s: 0.5, "
              "gyro_drift_time_constant_s: 0.2, accel_stddev_m_s2: 0.1, accel_vibration_m_s2: 0.0, "
              "position_B_m: [0.1, 0, 0]}");
  harness.add("gps",
              "{rate_hz: 5, position_stddev_m: 0.1, position_drift_stddev_m: 0.5, "
              "position_drift_time_constant_s: 0.5, velocity_stddev_m_s: 0.1, eph_m: 1, epv_m: 1, "
              "satellites: 10}");
  harness.add("magnetometer", "{rate_hz: 50, stddev_gauss: 0.004}");
  harness.add("barometer",
              "{rate_hz: 50, stddev_pa: 1, drift_stddev_pa: 2, drift_time_constant_s: 0.1}");
  harness.add("rangefinder", "{rate_hz: 50, stddev_m: 0.02, min_m: 0.1, max_m: 20}");
  RestStatistics rest;
  std::vector<Subscription> listening;
  listening.push_back(harness.bus.subscribe<ImuSample>("iris0/imu", [&](const ImuSample& s) {
    rest.gyro.add(s.angular_rate_B.x());
    rest.accel.add(s.specific_force_B.z());
  }));
  listening.push_back(harness.bus.subscribe<GpsSample>("iris0/gps", [&](const GpsSample& s) {
    rest.north.add(harness.world.projection().to_local(s.position).x());
    rest.climb.add(s.velocity_N.z());
  }));
  listening.push_back(harness.bus.subscribe<MagnetometerSample>(
      "iris0/magnetometer",
      [&](const MagnetometerSample& s) { rest.field.add(s.field_B_gauss.x()); }));
  listening.push_back(harness.bus.subscribe<BarometerSample>(
      "iris0/barometer", [&](const BarometerSample& s) { rest.pressure.add(s.pressure_pa); }));
  listening.push_back(harness.bus.subscribe<RangeSample>(
      "iris0/rangefinder", [&](const RangeSample& s) { rest.range.add(s.distance_m); }));
  harness.run(std::chrono::seconds(100));
  return rest;
}

TEST(Step, ChangesNoStatisticOfASensorAtRest) {
  // The models draw once per sample: with one seed the samples are the same numbers at any step.
  const RestStatistics fine = at_rest(std::chrono::microseconds(500));
  for (const int step_us : {1000, 4000}) {
    const RestStatistics coarse = at_rest(std::chrono::microseconds(step_us));
    const auto expect_same = [&](const Statistics& a, const Statistics& b, const char* name) {
      EXPECT_EQ(a.count(), b.count()) << name << " at " << step_us << " us";
      EXPECT_NEAR(a.mean(), b.mean(), 1e-9 * std::max(1.0, std::abs(a.mean()))) << name;
      EXPECT_NEAR(a.stddev(), b.stddev(), 1e-9 * std::max(1.0, a.stddev())) << name;
    };
    expect_same(fine.gyro, coarse.gyro, "gyro");
    expect_same(fine.accel, coarse.accel, "accel");
    expect_same(fine.north, coarse.north, "gps position");
    expect_same(fine.climb, coarse.climb, "gps velocity");
    expect_same(fine.field, coarse.field, "magnetometer");
    expect_same(fine.pressure, coarse.pressure, "barometer");
    expect_same(fine.range, coarse.range, "rangefinder");
  }
  EXPECT_NEAR(fine.gyro.stddev() * 180 / M_PI, std::hypot(0.05 * std::sqrt(250.0), 0.5), 0.03);
  EXPECT_NEAR(fine.pressure.stddev(), std::hypot(1, 2), 0.15);
  EXPECT_NEAR(fine.range.mean(), 5, 0.002);
}

/// A body that turns and shakes: mean over a sample period against the closed form.
TEST(Step, DoesNotChangeWhatTheImuSeesOfAMotion) {
  // w_z(t) = 3 sin(20 t), specific force turns with it. Truth per 4 ms sample: mean of w.
  for (const int step_us : {500, 1000, 2000, 4000}) {
    ImuParams params;
    params.rate_hz = 250;
    params.gyro.stddev = params.accel.stddev = Vector3d::Constant(1e-12);
    ImuModel imu(params, 1);
    const double dt = step_us * 1e-6;
    const auto rate = [](double t) { return 3 * std::sin(20 * t); };
    const auto angle = [](double t) { return 3.0 / 20 * (1 - std::cos(20 * t)); };
    double worst = 0;
    for (int i = 0; i < 4'000'000 / step_us; ++i) {
      const double begin = i * dt;
      const double end = begin + dt;
      BodyState state;
      state.q_WB = Eigen::AngleAxisd(angle(end), Vector3d::UnitZ());
      state.w_WB_B.z() = rate(end);
      state.alpha_WB_B.z() = (rate(end) - rate(begin)) / dt;
      imu.accumulate(state, {0, 0, -kGravity}, dt);
      if ((i + 1) % (4000 / step_us) != 0) continue;
      const double mean = (angle(end) - angle(end - 0.004)) / 0.004;
      worst = std::max(worst, std::abs(imu.sample({}, state).angular_rate_B.z() - mean));
    }
    EXPECT_LT(worst, 2e-3) << step_us;  // trapezoid over 4 ms: a^2 dt^2 / 12 of 3 rad/s
  }
}

TEST(Preset, IsReadByEverySensor) {
  for (const char* text : {"table1", "gazebo_classic", "pixhawk", "pixhawk_icm42605", "rtk",
                           "rotors_adis16448", "airsim_mpu6000", "jmavsim", "low_cost", "ideal"}) {
    SCOPED_TRACE(text);
    const std::string file = cas::test::source_dir() + "/config/sensors/" + text + ".yaml";
    const base::ConfigNode preset = base::sensor_set(base::ConfigNode::parse("a: " + file).at("a"));
    constexpr double kStep = 1e-3;
    EXPECT_GT(parse_imu_params(preset.at("imu"), kStep).rate_hz, 0);
    EXPECT_GT(read_at_rate<base::read_gps_sheet>(preset.at("gps"), kStep).rate_hz, 0);
    EXPECT_GT(read_at_rate<base::read_magnetometer_sheet>(preset.at("magnetometer"), kStep).rate_hz,
              0);
    EXPECT_GT(read_at_rate<base::read_barometer_sheet>(preset.at("barometer"), kStep).rate_hz, 0);
    EXPECT_GT(read_at_rate<base::read_rangefinder_sheet>(preset.at("rangefinder"), kStep).rate_hz,
              0);
    for (const char* sensor : {"imu", "gps", "magnetometer", "barometer", "rangefinder"}) {
      preset.at(sensor).reject_unused();
    }
  }
}

}  // namespace
}  // namespace cas::sim
