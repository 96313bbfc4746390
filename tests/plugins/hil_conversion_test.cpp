// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/hil_conversion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "base/earth/frames.hpp"
#include "tests/plugins/plugin_harness.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;
using Eigen::Vector3d;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::uint32_t bits(const mv::HilSensor& packet) {
  return static_cast<std::uint32_t>(packet.fields_updated);
}

TEST(HilSensor, CarriesSpecificForceAndRatesInForwardRightDown) {
  ImuSample sample{.time = base::SimTime(std::chrono::milliseconds(1234)),
                   .specific_force_B = {1, 2, 9.80665},
                   .angular_rate_B = {0.1, 0.2, 0.3}};
  mv::HilSensor packet;
  fill(packet, sample);
  EXPECT_EQ(packet.time_usec, 1234000U);
  EXPECT_FLOAT_EQ(packet.xacc, 1);
  EXPECT_FLOAT_EQ(packet.yacc, -2);
  EXPECT_FLOAT_EQ(packet.zacc, -9.80665F);  // at rest, level: (0, 0, -g)
  EXPECT_FLOAT_EQ(packet.xgyro, 0.1F);
  EXPECT_FLOAT_EQ(packet.ygyro, -0.2F);
  EXPECT_FLOAT_EQ(packet.zgyro, -0.3F);
  EXPECT_EQ(bits(packet), 0x003FU);
  EXPECT_EQ(packet.id, 0) << "the instance that drives the clock of PX4 1.16";
}

TEST(HilSensor, CarriesTheFieldInGaussForwardRightDown) {
  MagnetometerSample sample;
  sample.field_B_gauss = {0.2, 0.05, -0.43};
  mv::HilSensor packet;
  fill(packet, sample);
  EXPECT_FLOAT_EQ(packet.xmag, 0.2F);
  EXPECT_FLOAT_EQ(packet.ymag, -0.05F);
  EXPECT_FLOAT_EQ(packet.zmag, 0.43F);
  EXPECT_EQ(bits(packet), 0x01C0U);
}

TEST(HilSensor, CarriesPressureInHectopascal) {
  BarometerSample sample;
  sample.pressure_pa = 95600.5;
  sample.temperature_degc = 11.8;
  mv::HilSensor packet;
  fill(packet, sample);
  EXPECT_FLOAT_EQ(packet.abs_pressure, 956.005F);
  EXPECT_NEAR(packet.pressure_alt, 488, 1.5);
  EXPECT_FLOAT_EQ(packet.temperature, 11.8F);
  EXPECT_FLOAT_EQ(packet.diff_pressure, 0);
  EXPECT_EQ(bits(packet), 0x1A00U);
}

GpsSample home_sample() {
  return {.time = base::SimTime(std::chrono::milliseconds(200)),
          .satellites = 10,
          .position = {47.397742, 8.545594, 488.1234},
          .velocity_N = {3, -4, 1.234},
          .eph_m = 0.42,
          .epv_m = 0.3};
}

TEST(HilGps, CarriesDegE7MillimetresAndCentimetresPerSecond) {
  const mv::HilGps packet = to_hil_gps(home_sample());
  EXPECT_EQ(packet.time_usec, 200000U);
  EXPECT_EQ(packet.lat, 473977420);
  EXPECT_EQ(packet.lon, 85455940);
  EXPECT_EQ(packet.alt, 488123);
  EXPECT_EQ(packet.vn, 300);
  EXPECT_EQ(packet.ve, -400);
  EXPECT_EQ(packet.vd, 123);
  EXPECT_EQ(packet.vel, 500);    // horizontal
  EXPECT_EQ(packet.cog, 30687);  // atan2(-4, 3) = -53.13 deg
  EXPECT_EQ(packet.eph, 42);
  EXPECT_EQ(packet.epv, 30);
  EXPECT_EQ(static_cast<int>(packet.fix_type), 3);
  EXPECT_EQ(packet.satellites_visible, 10);
  EXPECT_EQ(packet.yaw, 0);  // not available
  EXPECT_EQ(packet.id, 0);   // the first receiver
}

/// Nose east, banked right by 0.1 rad, flying to the north-east and up, in wind from the west.
TEST(HilStateQuaternion, CarriesTheTrueMotionInForwardRightDownAndNorthEastDown) {
  test::ScriptedWorld world;
  world.body.p_WB = {200, 100, 12.3456};  // east, north, up
  world.body.v_WB = {4, 3, 0.5};
  world.body.q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0.1, 0, M_PI / 2));
  world.body.w_WB_B = {0.1, 0.2, 0.3};
  world.body.a_WB = {0.980665, 0, 0};  // along the nose: 0.1 g
  world.air.wind_W = {4, 0, 0.5};
  world.air.air_density_kg_m3 = 1.225 / 4;
  const mv::HilStateQuaternion packet = to_hil_state(base::SimTime(std::chrono::milliseconds(1234)),
                                                     world.body, world.air, world.projection());
  EXPECT_EQ(packet.time_usec, 1234000U);
  const Eigen::Quaterniond q_ND(packet.attitude_quaternion[0], packet.attitude_quaternion[1],
                                packet.attitude_quaternion[2], packet.attitude_quaternion[3]);
  EXPECT_TRUE(base::euler_rpy(q_ND).isApprox(Vector3d(0.1, 0, M_PI / 2), 1e-6));
  EXPECT_FLOAT_EQ(packet.rollspeed, 0.1F);
  EXPECT_FLOAT_EQ(packet.pitchspeed, -0.2F);
  EXPECT_FLOAT_EQ(packet.yawspeed, -0.3F);
  const base::Geodetic place = world.projection().to_geodetic({100, 200, -12.3456});
  EXPECT_NEAR(packet.lat, place.lat_deg * 1e7, 0.5);
  EXPECT_NEAR(packet.lon, place.lon_deg * 1e7, 0.5);
  EXPECT_NEAR(packet.alt, place.alt_m * 1e3, 0.5);
  EXPECT_GT(packet.alt, 490'000);
  EXPECT_EQ(packet.vx, 300);
  EXPECT_EQ(packet.vy, 400);
  EXPECT_EQ(packet.vz, -50);
  EXPECT_EQ(packet.true_airspeed, 300);
  EXPECT_NEAR(packet.ind_airspeed, 150, 1) << "a quarter of the density at sea level";
  EXPECT_EQ(packet.xacc, 100);
  EXPECT_EQ(packet.yacc, 0);
  EXPECT_EQ(packet.zacc, 0);
}

TEST(HilStateQuaternion, HoldsFastMotionAtTheEndOfTheField) {
  test::ScriptedWorld world;
  world.body.v_WB = {400, -400, 0};
  world.body.a_WB = {0, 0, -400};
  const mv::HilStateQuaternion packet = to_hil_state({}, world.body, world.air, world.projection());
  EXPECT_EQ(packet.vx, -32768);
  EXPECT_EQ(packet.vy, 32767);
  EXPECT_EQ(packet.zacc, 32767);
}

TEST(HilGps, RoundsRatherThanCuts) {
  GpsSample sample = home_sample();
  sample.position.lat_deg = -33.86882019999;
  EXPECT_EQ(to_hil_gps(sample).lat, -338688202);
}

TEST(HilGps, CourseStaysBelow36000) {
  GpsSample sample = home_sample();
  sample.velocity_N = {10, -1e-6, 0};  // a hair left of north
  EXPECT_EQ(to_hil_gps(sample).cog, 0);
  sample.velocity_N = {0, 1, 0};
  EXPECT_EQ(to_hil_gps(sample).cog, 9000);
  sample.velocity_N = {-1, 0, 0};
  EXPECT_EQ(to_hil_gps(sample).cog, 18000);
}

TEST(HilGps, HoldsFastVelocitiesAtTheEndOfTheField) {
  GpsSample sample = home_sample();
  sample.velocity_N = {400, -400, 0};
  const mv::HilGps packet = to_hil_gps(sample);
  EXPECT_EQ(packet.vn, 32767);
  EXPECT_EQ(packet.ve, -32768);
  EXPECT_EQ(packet.vel, 56569);
}

TEST(HilGps, SaysUnknownWithoutAFix) {
  GpsSample sample = home_sample();
  sample.fix_type = 1;
  sample.satellites = 0;
  sample.eph_m = sample.epv_m = 99;
  const mv::HilGps packet = to_hil_gps(sample);
  EXPECT_EQ(static_cast<int>(packet.fix_type), 1);
  EXPECT_EQ(packet.lat, 0);
  EXPECT_EQ(packet.vel, 65535);
  EXPECT_EQ(packet.cog, 65535);
  EXPECT_EQ(packet.eph, 9900);
}

struct NoSolution {
  const char* name;
  void (*spoil)(GpsSample&);
};

TEST(HilGpsWithout, ASolutionHasNoFix) {
  const NoSolution rows[] = {{"Latitude", [](GpsSample& s) { s.position.lat_deg = kNan; }},
                             {"Altitude", [](GpsSample& s) { s.position.alt_m = kInfinity; }},
                             {"Velocity", [](GpsSample& s) { s.velocity_N.y() = kNan; }}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    GpsSample sample;
    sample.fix_type = 3;
    sample.satellites = 12;
    sample.position = {47.4, 8.5, 488};
    row.spoil(sample);
    const mv::HilGps packet = to_hil_gps(sample);
    EXPECT_EQ(static_cast<int>(packet.fix_type), 1);
    EXPECT_EQ(packet.lat, 0);
    EXPECT_EQ(packet.alt, 0);
    EXPECT_EQ(packet.vn, 0);
    EXPECT_EQ(packet.vel, 65535);
    EXPECT_EQ(packet.cog, 65535);
  }
}

TEST(HilGps, AccuracyThatIsNotANumberIsUnknown) {
  GpsSample sample;
  sample.eph_m = sample.epv_m = kNan;
  const mv::HilGps packet = to_hil_gps(sample);
  EXPECT_EQ(packet.eph, 65535);
  EXPECT_EQ(packet.epv, 65535);
}

TEST(DistanceSensor, AReadingThatIsNotANumberIsInvalid) {
  RangeSample sample;
  sample.valid = true;
  sample.distance_m = kNan;
  const mv::DistanceSensor packet = to_distance_sensor(sample);
  EXPECT_EQ(packet.signal_quality, 1);
  EXPECT_EQ(packet.current_distance, 65535);
}

TEST(DistanceSensor, AReadingBeyondItsFieldIsInvalid) {
  RangeSample sample;
  sample.valid = true;
  sample.max_m = 2000;
  sample.distance_m = 655.3;
  EXPECT_EQ(to_distance_sensor(sample).signal_quality, 100);
  for (const double distance_m : {655.36, 700.0, 1500.0, 1e9, -0.1}) {
    sample.distance_m = distance_m;
    EXPECT_EQ(to_distance_sensor(sample).signal_quality, 1) << distance_m;
  }
}

TEST(DistanceSensor, CarriesCentimetresDownwards) {
  RangeSample sample{.time = base::SimTime(std::chrono::milliseconds(1234)),
                     .distance_m = 2.345,
                     .min_m = 0.2,
                     .max_m = 20,
                     .valid = true};
  const mv::DistanceSensor packet = to_distance_sensor(sample);
  EXPECT_EQ(packet.time_boot_ms, 1234U);
  EXPECT_EQ(packet.current_distance, 235);
  EXPECT_EQ(packet.min_distance, 20);
  EXPECT_EQ(packet.max_distance, 2000);
  EXPECT_EQ(static_cast<int>(packet.orientation), 25);
  EXPECT_EQ(packet.signal_quality, 100);
  sample.valid = false;
  EXPECT_EQ(to_distance_sensor(sample).signal_quality, 1);
}

TEST(DistanceSensor, SaysWhereTheBeamPoints) {
  const auto orientation = [](const Eigen::Vector3d& direction_B) {
    RangeSample sample;
    sample.direction_B = direction_B;
    return static_cast<int>(to_distance_sensor(sample).orientation);
  };
  const double half = std::sqrt(0.5);
  EXPECT_EQ(orientation({0, 0, -1}), 25) << "down: MAV_SENSOR_ROTATION_PITCH_270";
  EXPECT_EQ(orientation({0, 0, 1}), 24) << "up: PITCH_90";
  EXPECT_EQ(orientation({1, 0, 0}), 0) << "ahead: NONE";
  EXPECT_EQ(orientation({0, -1, 0}), 2) << "right: YAW_90";
  EXPECT_EQ(orientation({-1, 0, 0}), 4) << "behind: YAW_180";
  EXPECT_EQ(orientation({0, 1, 0}), 6) << "left: YAW_270";
  EXPECT_EQ(orientation({half, -half, 0}), 1) << "ahead to the right: YAW_45";

  RangeSample slanting;
  slanting.direction_B = Eigen::Vector3d(1, 0, -1).normalized();
  const mv::DistanceSensor packet = to_distance_sensor(slanting);
  EXPECT_EQ(static_cast<int>(packet.orientation), 100) << "none of them: CUSTOM";
  const Eigen::Quaterniond q(
      static_cast<double>(packet.quaternion[0]), static_cast<double>(packet.quaternion[1]),
      static_cast<double>(packet.quaternion[2]), static_cast<double>(packet.quaternion[3]));
  constexpr double kFloat = 1e-6;
  EXPECT_TRUE((q * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d(half, 0, half), kFloat));
}

TEST(BatteryStatus, CarriesTheWholePackInItsFirstCell) {
  const mv::BatteryStatus packet = to_battery_status(
      {.time = {}, .voltage_v = 15.4321, .current_a = 47.5, .used_ah = 0.123, .charge = 0.876});
  EXPECT_EQ(packet.id, 0);
  EXPECT_EQ(packet.voltages[0], 15432);  // mV
  EXPECT_EQ(packet.voltages[1], 65535) << "there is no second cell";
  EXPECT_EQ(packet.current_battery, 4750);  // cA
  EXPECT_EQ(packet.current_consumed, 123);  // mAh
  EXPECT_EQ(packet.battery_remaining, 88);  // %
  EXPECT_EQ(packet.temperature, 32767) << "unknown";
}

TEST(BatteryStatus, AVoltageThatOneFieldCannotHoldGoesOnInTheNext) {
  const mv::BatteryStatus packet = to_battery_status(
      {.time = {}, .voltage_v = 100, .current_a = 1000, .used_ah = 0, .charge = 1});
  EXPECT_EQ(packet.voltages[0], 65534);
  EXPECT_EQ(packet.voltages[1], 100'000 - 65534);
  EXPECT_EQ(packet.voltages[2], 65535);
  EXPECT_EQ(packet.current_battery, 32767) << "the most that it can say";
}

TEST(BatteryStatus, AnEmptyBatteryHasNoVoltage) {
  const mv::BatteryStatus packet =
      to_battery_status({.time = {}, .voltage_v = 0, .current_a = 0, .used_ah = 1, .charge = 0});
  EXPECT_EQ(packet.voltages[0], 0);
  EXPECT_EQ(packet.battery_remaining, 0);
}

TEST(SimulatorHeartbeat, IsAGenericSystemWithoutAutopilot) {
  const mv::Heartbeat packet = simulator_heartbeat();
  EXPECT_EQ(static_cast<int>(packet.type), 0);
  EXPECT_EQ(static_cast<int>(packet.autopilot), 8);
  EXPECT_EQ(static_cast<int>(packet.base_mode), 0);
}

TEST(HilControls, ScalesRollPitchYawThrottleToU2U3U4U1) {
  const base::ControlScales scales{
      .u1_max_n = 28, .u2_max_nm = 3, .u3_max_nm = 2, .u4_max_nm = 0.8};
  mv::HilControls packet{.time_usec = 5000,
                         .roll_ailerons = 0.5F,
                         .pitch_elevator = -0.25F,
                         .yaw_rudder = 0.125F,
                         .throttle = 0.75F};
  packet.mode = static_cast<decltype(packet.mode)>(128 + 32);
  const MotorCommand command = to_motor_command(packet, scales);
  EXPECT_EQ(command.kind, MotorCommand::Kind::kControlInputs);
  EXPECT_TRUE(command.armed);
  EXPECT_TRUE(command.values.isApprox(Eigen::Vector4d(21, 1.5, -0.5, 0.1)));
  EXPECT_EQ(base::to_time_usec(command.sensor_time), 5000U);
}

TEST(HilControls, HoldsFieldsToTheirRangesAndIsDisarmedWithoutTheBit) {
  const base::ControlScales scales{.u1_max_n = 1, .u2_max_nm = 1, .u3_max_nm = 1, .u4_max_nm = 1};
  mv::HilControls packet{.roll_ailerons = 2,
                         .pitch_elevator = -3,
                         .yaw_rudder = std::numeric_limits<float>::quiet_NaN(),
                         .throttle = -0.5F};
  packet.mode = static_cast<decltype(packet.mode)>(32);
  const MotorCommand command = to_motor_command(packet, scales);
  EXPECT_FALSE(command.armed);
  EXPECT_TRUE(command.values.isApprox(Eigen::Vector4d(0, 1, -1, 0)));
}

TEST(HilActuatorControls, AreSixteenOutputsHeldToTheirRange) {
  mv::HilActuatorControls packet{.controls = {0.7F, -0.1F, 1.5F, 0.2F, -3.0F, 0.6F}};
  packet.controls[15] = 0.9F;
  packet.mode = static_cast<decltype(packet.mode)>(181);
  const MotorCommand armed = to_motor_command(packet);
  EXPECT_EQ(armed.kind, MotorCommand::Kind::kMotorOutputs);
  EXPECT_TRUE(armed.armed);
  ASSERT_EQ(armed.values.size(), 16);
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(16);
  expected.head<6>() << 0.7, -0.1, 1, 0.2, -1, 0.6;
  expected[15] = 0.9;
  EXPECT_TRUE(armed.values.isApprox(expected, 1e-6));
  packet.mode = static_cast<decltype(packet.mode)>(53);
  EXPECT_FALSE(to_motor_command(packet).armed);
}

}  // namespace
}  // namespace cas::sim
