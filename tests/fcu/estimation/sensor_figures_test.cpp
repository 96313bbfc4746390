// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/sensor_figures.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"

namespace cas::fcu {
namespace {

constexpr double kDegree = M_PI / 180;

SensorFigures figures(const char* sensors) {
  return sensor_figures(base::ConfigNode::parse(sensors));
}

TEST(SensorFigures, OfAnImuAreItsNoiseItsShakingAndItsDrift) {
  const SensorFigures got = figures(
      "imu: {rate_hz: 400, gyro_density_deg_s_per_sqrt_hz: 0.02, accel_stddev_m_s2: [3, 1, 1], "
      "accel_vibration_m_s2: [0, 0, 2], vibration_reference_rad_s: 800, "
      "gyro_drift_stddev_deg_s: [1, 2, 3], gyro_drift_time_constant_s: 200}");
  EXPECT_EQ(got.rates.imu_hz, 400);
  EXPECT_NEAR(got.params.gyro_noise_rad_s.x(), 0.4 * kDegree, 1e-12);
  EXPECT_NEAR(got.params.accel_noise_m_s2.x(), 3, 1e-12);
  EXPECT_NEAR(got.params.accel_noise_m_s2.z(), 3, 1e-12);       // sqrt(1 + 2 * 2^2)
  EXPECT_NEAR(got.gyro_bias_walk_rad_s, 0.3 * kDegree, 1e-12);  // 3 sqrt(2 / 200)
  EXPECT_EQ(got.accel_bias_walk_m_s2, 0);
}

TEST(SensorFigures, OfAMissingSensorAreTheDefaults) {
  const SensorFigures got = figures("barometer: {rate_hz: 25, stddev_pa: 4}");
  EXPECT_EQ(got.rates.baro_hz, 25);
  EXPECT_EQ(got.rates.imu_hz, SensorRates{}.imu_hz);
  EXPECT_EQ(got.params.gyro_noise_rad_s, EstimatorParams{}.gyro_noise_rad_s);
}

TEST(SensorFigures, AreNoneOfABlockThatThePluginRefuses) {
  EXPECT_THROW(figures("barometer: {rate_hz: 25, stddev_pa: 0}"), base::ConfigError);
  EXPECT_THROW(figures("barometer: {rate_hz: 25}"), base::ConfigError);
  EXPECT_THROW(figures("magnetometer: {rate_hz: 0, stddev_gauss: 0.01}"), base::ConfigError);
}

}  // namespace
}  // namespace cas::fcu
