// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sensor_names.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/refusal.hpp"

namespace cas::base {
namespace {

std::string refusal(const std::string& params, const char* plugin) {
  return test::refusal([&] { sensor_number(ConfigNode::parse(params, "file"), plugin); });
}

TEST(SensorName, TheFirstHasThatOfItsPluginAndTheOthersTheirNumber) {
  EXPECT_EQ(sensor_name("imu", 1), "imu");
  EXPECT_EQ(sensor_name("magnetometer", 3), "magnetometer_3");
  const auto third = parse_sensor_name("imu_3");
  ASSERT_TRUE(third);
  EXPECT_EQ(third->plugin, "imu");
  EXPECT_EQ(third->number, 3);
  EXPECT_EQ(parse_sensor_name("gps")->number, 1);
  for (const char* word : {"imu_1", "imu_4", "gps_3", "airspeed", "imu_", "imu_22", "motor_2"}) {
    EXPECT_FALSE(parse_sensor_name(word)) << word;
  }
}

TEST(SensorNumber, IsWithinWhatAVehicleMayHave) {
  EXPECT_EQ(sensor_number(ConfigNode::parse("{plugin: imu}"), "imu"), 1);
  EXPECT_EQ(sensor_number(ConfigNode::parse("{plugin: imu, number: 3}"), "imu"), 3);
  EXPECT_NE(refusal("{number: 3}", "gps").find("file:1: number: "), std::string::npos);
  EXPECT_NE(refusal("{number: 2}", "motor").find("a vehicle has one plugin 'motor'"),
            std::string::npos);
}

TEST(SensorBlock, AFurtherOneHasItsKeysOverThoseOfTheFirst) {
  const auto set = ConfigNode::parse("{imu: {a: 1, b: 2}, imu_2: {b: 3}, gps: {a: 5}}");
  const auto second = sensor_block(set, "imu_2");
  ASSERT_TRUE(second);
  EXPECT_EQ(second->require<int>("a"), 1);
  EXPECT_EQ(second->require<int>("b"), 3);
  EXPECT_EQ(sensor_block(set, "imu")->require<int>("b"), 2);
  EXPECT_EQ(sensor_block(set, "gps_2")->require<int>("a"), 5);
  EXPECT_FALSE(sensor_block(set, "barometer_2"));
  EXPECT_EQ(further_sensors(set), std::vector<std::string>{"imu_2"});
}

}  // namespace
}  // namespace cas::base
