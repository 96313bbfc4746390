// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sensor_sheets.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/refusal.hpp"

namespace cas::base {
namespace {

constexpr const char* kNoise = "gyro_stddev_deg_s: 1, accel_stddev_m_s2: 0.1";

ImuSheet imu(const std::string& keys) {
  return read_imu_sheet(ConfigNode::parse("{rate_hz: 400, " + keys + "}"));
}

TEST(SensorSheets, OneNumberStandsForThreeAxes) {
  const ImuSheet sheet = imu("gyro_stddev_deg_s: 2, accel_stddev_m_s2: [1, 2, 3]");
  EXPECT_EQ(sheet.gyro.noise.figure(), Eigen::Vector3d(2, 2, 2));
  EXPECT_EQ(sheet.accel.noise.figure(), Eigen::Vector3d(1, 2, 3));
}

TEST(SensorSheets, ADensityCountsWithTheRootOfTheRate) {
  const ImuSheet sheet = imu("gyro_density_deg_s_per_sqrt_hz: 0.05, accel_stddev_m_s2: 1");
  EXPECT_EQ(sheet.gyro.noise.per_sample(sheet.rate_hz), 20);
  EXPECT_EQ(sheet.accel.noise.per_sample(sheet.rate_hz), 1);
}

TEST(SensorSheets, EachTriadHasItsOwnKeys) {
  const ImuSheet sheet = imu(std::string(kNoise) +
                             ", gyro_lsb_deg_s: 0.5, accel_range_m_s2: 80, accel_bias_m_s2: 0.2, "
                             "gyro_drift_stddev_deg_s: 3, gyro_drift_time_constant_s: 60");
  EXPECT_EQ(sheet.gyro.lsb, 0.5);
  EXPECT_EQ(sheet.accel.lsb, 0);
  EXPECT_EQ(sheet.accel.range, 80);
  EXPECT_EQ(sheet.accel.bias.y(), 0.2);
  EXPECT_EQ(sheet.gyro.drift.time_constant_s, 60);
  EXPECT_FALSE(sheet.accel.drift.stddev);
}

TEST(SensorSheetRefuses, WithASentenceThatNamesTheKey) {
  struct RefusedSheet {
    const char* keys;  ///< beside those of kNoise
    const char* says;
  };
  const RefusedSheet rows[] = {
      {"gyro_drift_stddev_deg_s: 1, gyro_drift_time_constant_s: 60, "
       "gyro_bias_walk_deg_s_per_sqrt_s: 1, gyro_bias_time_constant_s: 0",
       "drift has one figure"},
      {"gyro_drift_stddev_deg_s: 1", "gyro_drift_time_constant_s"},
      {"accel_bias_time_constant_s: 60", "has no meaning without accel_bias_walk_m_s2_per_sqrt_s"},
      {"accel_turn_on_bias_stddev_m_s2: [0, -1, 0]",
       "accel_turn_on_bias_stddev_m_s2: must not be negative"},
      {"gyro_scale_error: 2", "gyro_scale_error: is a fraction"},
      {"gyro_vibration_deg_s: 1", "without vibration_reference_rad_s"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.keys);
    const std::string said =
        cas::test::refusal([&] { imu(std::string(kNoise) + ", " + row.keys); });
    EXPECT_NE(said.find(row.says), std::string::npos) << said;
  }
}

TEST(SensorSheets, ARangefinderReachesNoLessThanItsNearest) {
  EXPECT_THROW(read_rangefinder_sheet(
                   ConfigNode::parse("{rate_hz: 20, stddev_m: 0.01, min_m: 2, max_m: 1}")),
               ConfigError);
}

TEST(SensorSheets, TheMagneticMatrixHasNineNumbers) {
  const std::string keys = "{rate_hz: 50, stddev_gauss: 0.01, soft_iron: ";
  const auto sheet =
      read_magnetometer_sheet(ConfigNode::parse(keys + "[1, 2, 3, 4, 5, 6, 7, 8, 9]}"));
  EXPECT_EQ(sheet.soft_iron(0, 1), 2);
  EXPECT_THROW(read_magnetometer_sheet(ConfigNode::parse(keys + "[1, 2, 3]}")), ConfigError);
}

}  // namespace
}  // namespace cas::base
