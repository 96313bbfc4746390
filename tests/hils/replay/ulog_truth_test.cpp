// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/ulog_truth.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "hils/replay/ulog_messages.hpp"
#include "tests/hils/ulog/ulog_bytes.hpp"

namespace cas::hils {
namespace {

using cas::test::UlogBytes;
using OrderedJson = nlohmann::ordered_json;

constexpr std::uint64_t kTruthStart = 5'000'000;
constexpr std::uint64_t kPeriod_us = 20'000;

/// Ids of the log's topics.
enum Id : std::uint16_t { kAttitude, kRates, kTruth, kRotors, kEstimate, kSetpoint };

UlogBytes truth_log() {
  const std::string home =
      "double ref_lat;double ref_lon;float ref_alt;bool xy_global;bool z_global;";
  return UlogBytes(kTruthStart)
      .format("vehicle_attitude_groundtruth:uint64_t timestamp;float[4] q;")
      .format("vehicle_angular_velocity_groundtruth:uint64_t timestamp;float[3] xyz;")
      .format(
          "vehicle_local_position_groundtruth:uint64_t timestamp;float x;float y;float z;float "
          "vx;float vy;"
          "float vz;" +
          home)
      .format("rotor_speeds:uint64_t timestamp;float[2] omega_rad_s;")
      .format("vehicle_local_position:uint64_t timestamp;" + home)
      .format(
          "vehicle_local_position_setpoint:uint64_t timestamp;float x;float y;float z;float yaw;")
      .subscribe(kAttitude, "vehicle_attitude_groundtruth")
      .subscribe(kRates, "vehicle_angular_velocity_groundtruth")
      .subscribe(kTruth, "vehicle_local_position_groundtruth")
      .subscribe(kRotors, "rotor_speeds")
      .subscribe(kEstimate, "vehicle_local_position")
      .subscribe(kSetpoint, "vehicle_local_position_setpoint");
}

template <std::size_t N>
std::string floats(const std::array<float, N>& values) {
  std::string bytes;
  for (const float value : values) bytes += UlogBytes::number(value);
  return bytes;
}

std::string home(double lat_deg, double lon_deg, float alt_m, bool is_known = true) {
  return UlogBytes::number(lat_deg) + UlogBytes::number(lon_deg) + UlogBytes::number(alt_m) +
         UlogBytes::number(is_known) + UlogBytes::number(is_known);
}

const std::string kNowhere = home(0, 0, 0, false);

/// Heading east, turning right at 0.5 rad/s.
UlogBytes& add_attitude(UlogBytes& bytes, std::uint64_t time_us) {
  const float half = std::sqrt(0.5F);
  return bytes.data(kAttitude, time_us, floats<4>({half, 0, 0, half}))
      .data(kRates, time_us, floats<3>({0, 0, 0.5F}));
}

/// The last number of a column.
double last(const OrderedJson& column) {
  double sum = 0;
  for (const OrderedJson& difference : column["d"]) sum += difference.get<double>();
  return sum * column["k"].get<double>();
}

TEST(UlogTruth, IsTheMotionOnTheAxesOfTruthCsv) {
  UlogBytes bytes = truth_log();
  for (std::uint64_t i = 0; i < 2; ++i) {
    const std::uint64_t time_us = kTruthStart + i * kPeriod_us;
    add_attitude(bytes, time_us)
        .data(kTruth, time_us, floats<6>({1, 2, -3, 0.4F, 0.5F, -0.6F}) + kNowhere)
        .data(kRotors, time_us, floats<2>({500, 600}));
  }
  const OrderedJson truth = ulog_messages(bytes.bytes())["truth"];
  ASSERT_TRUE(truth.is_object());
  EXPECT_EQ(truth["t"]["d"].size(), 2U);
  constexpr double kStep = 0.002;  // resolution of the record
  const auto expect = [&](const char* name, double value) {
    EXPECT_NEAR(last(truth[name]), value, kStep) << name;
  };
  expect("t", 0.02);
  expect("x", 1);
  expect("y", 2);
  expect("z", 3);
  expect("vx", 0.4);
  expect("vy", 0.5);
  expect("vz", 0.6);
  expect("roll", 0);
  expect("yaw", M_PI / 2);
  expect("r", 0.5);
  expect("rotor1", 500);
  expect("rotor2", 600);
}

TEST(UlogTruth, WithoutAnAttitudeThereIsNone) {
  UlogBytes bytes = truth_log();
  bytes.data(kTruth, kTruthStart, floats<6>({}) + kNowhere)
      .data(kAttitude, kTruthStart, floats<4>({0, 0, 0, 0}))
      .data(kTruth, kTruthStart + kPeriod_us, floats<6>({}) + kNowhere);
  EXPECT_TRUE(ulog_messages(bytes.bytes())["truth"].is_null());
}

TEST(UlogTruth, TheEstimateCountsFromItsOwnPlaceOnEarth) {
  UlogBytes bytes = truth_log();
  add_attitude(bytes, kTruthStart);
  bytes.data(kEstimate, kTruthStart, kNowhere)
      .data(kEstimate, kTruthStart,
            home(47.001, 8, 490))  // 111.2 m north of the truth's home, 2 m above
      .data(kTruth, kTruthStart, floats<6>({100, 0, 0, 0, 0, 0}) + home(47, 8, 488))
      .data(kSetpoint, kTruthStart, floats<4>({5, 6, -7, 1}));
  const OrderedJson vehicle = ulog_messages(bytes.bytes());
  EXPECT_NEAR(vehicle["origin"][0].get<double>(), 0, 0.01);
  EXPECT_NEAR(vehicle["origin"][1].get<double>(), 111.19, 0.01);
  EXPECT_NEAR(vehicle["origin"][2].get<double>(), 2, 0.01);
  EXPECT_NEAR(last(vehicle["reference"]["x"]), 116.19, 0.01);
  EXPECT_NEAR(last(vehicle["reference"]["y"]), 6, 0.01);
  EXPECT_NEAR(last(vehicle["reference"]["z"]), 9, 0.01);
  EXPECT_NEAR(last(vehicle["reference"]["yaw"]), 1, 0.001);
}

TEST(UlogTruth, WithoutPlacesTheEstimateCountsFromTheStart) {
  UlogBytes bytes = truth_log();
  add_attitude(bytes, kTruthStart);
  bytes.data(kTruth, kTruthStart, floats<6>({10, 20, -30, 0, 0, 0}) + kNowhere);
  EXPECT_EQ(ulog_messages(bytes.bytes())["origin"].dump(), "[20.0,10.0,30.0]");
}

TEST(UlogTruth, AnAxisWithoutASetpointIsNoReference) {
  UlogBytes bytes = truth_log();
  bytes.data(kSetpoint, kTruthStart, floats<4>({5, std::nanf(""), -7, 1}));
  EXPECT_TRUE(ulog_messages(bytes.bytes())["reference"].is_null());
}

}  // namespace
}  // namespace cas::hils
