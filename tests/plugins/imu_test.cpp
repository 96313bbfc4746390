// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "plugins/imu/imu_model.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/statistics.hpp"
#include "tests/support/refusal.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;
using test::kGravity;
using test::Statistics;

const Vector3d kGravityW(0, 0, -kGravity);
constexpr double kDegree = M_PI / 180.0;

/// Noise far below the tests' tolerances.
ImuParams quiet_params() {
  ImuParams params;
  params.rate_hz = 500;
  params.gyro.stddev = params.accel.stddev = Vector3d::Constant(1e-12);
  return params;
}

ImuSample one_sample(const ImuParams& params, const BodyState& state) {
  ImuModel imu(params, 1);
  imu.accumulate(state, kGravityW, 0.002);
  return imu.sample(base::SimTime{}, state);
}

constexpr double kQuiet = 1e-10;  // ten times the noise above

TEST(Imu, AccelerometerReadsPlusOneGUpwardsAtRest) {
  const ImuSample sample = one_sample(quiet_params(), {});
  EXPECT_TRUE(sample.specific_force_B.isApprox(Vector3d(0, 0, kGravity), kQuiet));
  EXPECT_NEAR(sample.angular_rate_B.norm(), 0, kQuiet);
}

TEST(Imu, AccelerometerReadsZeroInFreeFall) {
  BodyState state{.a_WB = kGravityW};
  EXPECT_NEAR(one_sample(quiet_params(), state).specific_force_B.norm(), 0, kQuiet);
}

TEST(Imu, SpecificForceTurnsWithTheBody) {
  BodyState state;
  state.q_WB = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX());  // right side down
  EXPECT_TRUE(one_sample(quiet_params(), state)
                  .specific_force_B.isApprox(Vector3d{0, kGravity, 0}, kQuiet));
}

TEST(Imu, LeverArmFeelsAngularAccelerationAndCentripetalForce) {
  ImuParams params = quiet_params();
  params.position_B_m = {0.1, 0, 0};
  BodyState state;
  state.a_WB = kGravityW;  // so that only the lever arm is left
  state.w_WB_B = {0, 0, 3};
  EXPECT_TRUE(one_sample(params, state).specific_force_B.isApprox(Vector3d{-0.9, 0, 0}, kQuiet));
  state.w_WB_B = {0, 0, 0.005};  // mid-step rate zero: only alpha is left
  state.alpha_WB_B = {0, 0, 5};
  EXPECT_TRUE(one_sample(params, state).specific_force_B.isApprox(Vector3d{0, 0.5, 0}, 1e-6));
}

TEST(Imu, MountingTurnsTheReading) {
  const auto node = base::ConfigNode::parse(
      "{rate_hz: 500, gyro_stddev_deg_s: 1.0e-9, accel_stddev_m_s2: 1.0e-9, "
      "mounting_rpy_deg: [180, 0, 0]}");
  const ImuSample sample = one_sample(parse_imu_params(node, 1e-3), {});
  EXPECT_TRUE(sample.specific_force_B.isApprox(Vector3d(0, 0, -kGravity), 1e-7));
}

TEST(Imu, SpecificForceAddsARateByItsSensitivity) {
  ImuParams params = quiet_params();
  params.gyro_g_sensitivity = {0, 0, 0.001};
  EXPECT_NEAR(one_sample(params, {}).angular_rate_B.z(), 0.001 * kGravity, kQuiet);
}

TEST(Imu, BiasesFollowTheTemperatureOfTheWarmUp) {
  ImuParams params = quiet_params();
  params.start_degc = 5;
  params.warm_up_degc = 20;
  params.warm_up_time_constant_s = 100;
  params.gyro.temperature = {0.01, 0, 0};
  params.accel.temperature_squared = {0, 0.002, 0};
  ImuModel imu(params, 1);
  for (const double time_s : {0.0, 100.0, 1e5}) {
    imu.accumulate({}, kGravityW, 0.002);
    const ImuSample sample = imu.sample(base::SimTime(base::from_seconds(time_s)), {});
    const double degc = 5 + 20 * (1 - std::exp(-time_s / 100));
    EXPECT_NEAR(sample.angular_rate_B.x(), 0.01 * degc, kQuiet) << time_s;
    EXPECT_NEAR(sample.specific_force_B.y(), 0.002 * degc * degc, kQuiet) << time_s;
  }
}

/// Amplitude of a series at a frequency that has whole periods in it.
double amplitude_at(const std::vector<double>& values, double hz, double rate_hz) {
  double in_phase = 0;
  double across = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double angle = 2 * M_PI * hz * static_cast<double>(i) / rate_hz;
    in_phase += values[i] * std::cos(angle);
    across += values[i] * std::sin(angle);
  }
  return 2 * std::hypot(in_phase, across) / static_cast<double>(values.size());
}

TEST(Imu, VibrationStandsAtTheRotorsFrequenciesAndTheirMultiples) {
  constexpr double kRateHz = 2000;
  const std::array<double, 4> rotors_hz{80, 95, 110, 125};
  const std::array<double, 4> imbalance{1, 2, 0.5, 1};  // the last is not listed
  ImuParams params = quiet_params();
  params.rate_hz = kRateHz;
  params.accel.vibration = Vector3d::Constant(1.5);
  params.vibration_reference_rad_s = 600;
  params.vibration_harmonics = {0.5, 0.25};
  params.vibration_imbalance = {1, 2, 0.5};
  base::RotorVector omega(4);
  for (int i = 0; i < 4; ++i) omega[i] = 2 * M_PI * rotors_hz[static_cast<std::size_t>(i)];
  ImuModel imu(params, 1);
  std::vector<double> forces;
  for (int i = 0; i < kRateHz; ++i) {
    imu.accumulate({}, kGravityW, 1 / kRateHz);
    imu.advance_vibration(omega, 1 / kRateHz);
    forces.push_back(imu.sample(base::SimTime{}, {}).specific_force_B.x());
  }
  constexpr double kRounding = 1e-6;
  for (std::size_t i = 0; i < 4; ++i) {
    const double first =
        1.5 * imbalance[i] * std::pow(omega[static_cast<Eigen::Index>(i)] / 600, 2);
    EXPECT_NEAR(amplitude_at(forces, rotors_hz[i], kRateHz), first, kRounding) << i;
    EXPECT_NEAR(amplitude_at(forces, 2 * rotors_hz[i], kRateHz), 0.5 * first, kRounding) << i;
    EXPECT_NEAR(amplitude_at(forces, 3 * rotors_hz[i], kRateHz), 0.25 * first, kRounding) << i;
  }
  EXPECT_NEAR(amplitude_at(forces, 100, kRateHz), 0, kRounding);
}

TEST(Imu, ScaleErrorAndMisalignmentBendTheReading) {
  const auto node = base::ConfigNode::parse(
      "{rate_hz: 500, gyro_stddev_deg_s: 1.0e-9, accel_stddev_m_s2: 1.0e-9, "
      "accel_scale_error: [0, 0, 0.01], accel_misalignment_deg: [1, 0, 0]}");
  const ImuSample sample = one_sample(parse_imu_params(node, 1e-3), {});
  // An axis pair rolled by 1 degree sees g sin(1) on y and g cos(1) on z.
  EXPECT_NEAR(sample.specific_force_B.y(), kGravity * std::sin(kDegree), 1e-6);
  EXPECT_NEAR(sample.specific_force_B.z(), 1.01 * kGravity * std::cos(kDegree), 1e-6);
}

TEST(Imu, ClipsAtItsRangeAndRoundsToItsResolution) {
  ImuParams params = quiet_params();
  params.gyro.range = 10;
  params.gyro.lsb = 0.25;
  BodyState state{.w_WB_B = {20, -20, 1.3}};
  EXPECT_TRUE(one_sample(params, state).angular_rate_B.isApprox(Vector3d{10, -10, 1.25}, kQuiet));
}

TEST(Imu, TurnOnBiasIsDrawnOnceForEachRun) {
  ImuParams params = quiet_params();
  params.gyro.turn_on_bias_stddev = {0.1, 0.2, 0.0};
  params.accel.turn_on_bias_stddev = {0.0, 0.0, 0.3};
  std::array<Statistics, 3> biases;
  constexpr std::uint64_t kRuns = 4000;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    ImuModel imu(params, seed);
    imu.accumulate({}, kGravityW, 0.002);
    const ImuSample first = imu.sample(base::SimTime{}, {});
    imu.accumulate({}, kGravityW, 0.002);
    EXPECT_TRUE(imu.sample({}, {}).angular_rate_B.isApprox(first.angular_rate_B, 1e-6));
    EXPECT_NEAR(first.angular_rate_B.z(), 0, kQuiet);
    biases[0].add(first.angular_rate_B.x());
    biases[1].add(first.angular_rate_B.y());
    biases[2].add(first.specific_force_B.z() - kGravity);
  }
  const std::array<double, 3> expected{0.1, 0.2, 0.3};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(biases[i].stddev() / expected[i], 1, 0.045) << i;  // 4 standard errors
    EXPECT_NEAR(biases[i].mean() / expected[i], 0, 0.063) << i;
  }
}

TEST(Imu, VibratesAtTheRotorsSpeed) {
  ImuParams params = quiet_params();
  params.rate_hz = 1000;
  params.accel.vibration = Vector3d::Constant(2.0);
  // One rotor at half the reference speed: amplitude 2 / 4, period 8 ms.
  const double omega = 2 * M_PI * 125;
  params.vibration_reference_rad_s = 2 * omega;
  ImuModel imu(params, 1);
  std::vector<double> x;
  for (int i = 0; i < 1000; ++i) {
    imu.accumulate({}, kGravityW, 1e-3);
    imu.advance_vibration(Eigen::Vector4d(omega, 0, 0, 0), 1e-3);
    x.push_back(imu.sample(base::SimTime{}, {}).specific_force_B.x());
  }
  for (std::size_t i = 8; i < x.size(); ++i) EXPECT_NEAR(x[i], x[i - 8], 1e-9);
  Statistics spread;
  for (const double value : x) spread.add(value);
  EXPECT_NEAR(spread.stddev(), 0.5 / std::sqrt(2.0), 1e-3);
}

TEST(Imu, TableOneNoiseIsPerSampleAndPerAxis) {
  const auto node = base::ConfigNode::parse(
      "{rate_hz: 500, gyro_stddev_deg_s: [0.67, 0.78, 0.12], accel_stddev_m_s2: [0.04, 0.06, "
      "0.07]}");
  ImuModel imu(parse_imu_params(node, 1e-3), 7);
  std::array<Statistics, 6> axes;
  constexpr int kSamples = 100000;
  for (int i = 0; i < kSamples; ++i) {
    imu.accumulate({}, kGravityW, 2e-3);
    const ImuSample sample = imu.sample(base::SimTime{}, {});
    for (int axis = 0; axis < 3; ++axis) {
      axes[static_cast<std::size_t>(axis)].add(sample.angular_rate_B[axis] / kDegree);
      axes[static_cast<std::size_t>(axis + 3)].add(sample.specific_force_B[axis]);
    }
  }
  const std::array<double, 6> expected{0.67, 0.78, 0.12, 0.04, 0.06, 0.07};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    EXPECT_NEAR(axes[i].stddev() / expected[i], 1.0, 0.01);  // 4 standard errors
    EXPECT_NEAR((axes[i].mean() - (i == 5 ? kGravity : 0.0)) / expected[i], 0.0, 0.015);
  }
}

TEST(Imu, DensityBecomesADeviationOfDensityTimesRootRate) {
  const auto node = base::ConfigNode::parse(
      "{rate_hz: 400, gyro_density_deg_s_per_sqrt_hz: 0.05, accel_stddev_m_s2: 0.1}");
  const ImuParams params = parse_imu_params(node, 1e-3);
  EXPECT_NEAR(params.gyro.stddev.x(), 0.05 * kDegree * 20, 1e-12);
  EXPECT_NEAR(params.accel.stddev.x(), 0.1, 1e-12);
}

TEST(ImuRefuses, WithASentenceThatNamesTheKey) {
  struct RefusedCase {
    const char* yaml;
    const char* says;
  };
  const RefusedCase rows[] = {
      {"{rate_hz: 500, gyro_stddev_deg_s: 1, gyro_density_deg_s_per_sqrt_hz: 1, "
       "accel_stddev_m_s2: 1}",
       "gyro_density_deg_s_per_sqrt_hz"},
      {"{rate_hz: 500, gyro_stddev_deg_s: 1}", "accel_stddev_m_s2"},
      {"{rate_hz: 500, gyro_stddev_deg_s: [1, 0, 1], accel_stddev_m_s2: 1}", "stale"},
      {"{rate_hz: 2000, gyro_stddev_deg_s: 1, accel_stddev_m_s2: 1}", "rate_hz"},
      {"{rate_hz: 500, gyro_stddev_deg_s: 1, accel_stddev_m_s2: 1, accel_vibration_m_s2: 1}",
       "vibration_reference_rad_s"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.yaml);
    const std::string said =
        test::refusal([&] { parse_imu_params(base::ConfigNode::parse(row.yaml), 1e-3); });
    EXPECT_NE(said.find(row.says), std::string::npos) << said;
  }
}

constexpr const char* kTable1 =
    "{rate_hz: 500, gyro_stddev_deg_s: [0.67, 0.78, 0.12], accel_stddev_m_s2: [0.04, 0.06, 0.07]}";

TEST(ImuRate, IsExactInCount) {
  struct RateCase {
    const char* name;
    double rate_hz;
    int step_us;
    std::size_t in_ten_seconds;
  };
  const RateCase rows[] = {{"Imu500HzAt1ms", 500, 1000, 5000},  {"Imu400HzAt1ms", 400, 1000, 4000},
                           {"Imu250HzAt1ms", 250, 1000, 2500},  {"Imu250HzAt4ms", 250, 4000, 2500},
                           {"Imu100HzAt4ms", 100, 4000, 1000},  {"Imu50HzAt4ms", 50, 4000, 500},
                           {"Imu500HzAt500us", 500, 500, 5000}, {"Imu500HzAt2ms", 500, 2000, 5000},
                           {"Imu333HzAt250us", 333, 250, 3330}};
  for (const auto& rate : rows) {
    SCOPED_TRACE(rate.name);
    test::PluginHarness harness{std::chrono::microseconds(rate.step_us)};
    harness.add("imu", "{rate_hz: " + std::to_string(rate.rate_hz) +
                           ", gyro_stddev_deg_s: 1, accel_stddev_m_s2: 1}");
    std::size_t count = 0;
    const auto listening =
        harness.bus.subscribe<ImuSample>("iris0/imu", [&](const ImuSample&) { ++count; });
    harness.run(std::chrono::seconds(10));
    EXPECT_EQ(count, rate.in_ten_seconds);
  }
}

TEST(ImuPlugin, ShakesOnlyWhileTheRotorsTurn) {
  test::PluginHarness harness;
  const auto speeds = harness.bus.advertise<RotorSpeeds>("iris0/rotor_speeds");
  harness.add("imu",
              "{rate_hz: 500, gyro_stddev_deg_s: 1.0e-6, accel_stddev_m_s2: 1.0e-6, "
              "accel_vibration_m_s2: 3, vibration_reference_rad_s: 800}");
  Statistics spread;
  const auto listening = harness.bus.subscribe<ImuSample>(
      "iris0/imu", [&](const ImuSample& s) { spread.add(s.specific_force_B.x()); });
  harness.run(std::chrono::milliseconds(200));
  EXPECT_LT(spread.stddev(), 1e-5);
  spread = {};
  // Four rotors of one speed whose phases are drawn: up to four amplitudes of 3 (700 / 800)^2.
  speeds.publish({.time = {}, .omega_rad_s = Eigen::Vector4d(700, 710, 690, 720)});
  harness.run(std::chrono::seconds(4));
  EXPECT_NEAR(spread.stddev(), 3 * std::pow(705.0 / 800, 2) * std::sqrt(4.0 / 2), 0.4);
}

TEST(ImuPlugin, RepeatsItselfAfterReset) {
  test::PluginHarness harness;
  harness.add("imu", kTable1);
  std::vector<Vector3d> rates;
  const auto listening = harness.bus.subscribe<ImuSample>(
      "iris0/imu", [&](const ImuSample& sample) { rates.push_back(sample.angular_rate_B); });
  harness.run(std::chrono::milliseconds(100));
  const std::vector<Vector3d> first = std::move(rates);
  rates.clear();
  harness.reset();
  harness.run(std::chrono::milliseconds(100));
  EXPECT_EQ(first, rates);
}

TEST(ImuPlugin, NeverRepeatsAValue) {
  test::PluginHarness harness;
  harness.add("imu", kTable1);
  std::set<float> values;
  std::size_t count = 0;
  const auto listening = harness.bus.subscribe<ImuSample>("iris0/imu", [&](const ImuSample& s) {
    ++count;
    values.insert(static_cast<float>(s.specific_force_B.x()));
  });
  harness.run(std::chrono::seconds(2));
  EXPECT_GE(values.size(), count - 2);  // by chance two floats may meet
}

}  // namespace
}  // namespace cas::sim
