// SPDX-License-Identifier: BSD-3-Clause
// Every message that the controller tells about itself, against a hover whose truth is known:
// units, signs, frames.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "base/earth/frames.hpp"
#include "mavlink/common/altitude.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/attitude_quaternion.hpp"
#include "mavlink/common/attitude_target.hpp"
#include "mavlink/common/battery_status.hpp"
#include "mavlink/common/current_mode.hpp"
#include "mavlink/common/estimator_status.hpp"
#include "mavlink/common/extended_sys_state.hpp"
#include "mavlink/common/global_position_int.hpp"
#include "mavlink/common/gps_global_origin.hpp"
#include "mavlink/common/gps_raw_int.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/local_position_ned.hpp"
#include "mavlink/common/mission_current.hpp"
#include "mavlink/common/position_target_local_ned.hpp"
#include "mavlink/common/scaled_pressure.hpp"
#include "mavlink/common/servo_output_raw.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink/common/system_time.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink/common/vfr_hud.hpp"
#include "mavlink/common/vibration.hpp"
#include "tests/fcu/support/closed_loop.hpp"

namespace cas::fcu {
namespace {

using namespace mavlink::common;  // NOLINT
using test::ClosedLoop;
using test::LoopOptions;

/// Hovers at 6 m north, 4 m west, 5 m up, nose to 0.7 rad east of north; flown once.
class Telemetry : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    LoopOptions options;
    options.noise = test::rtk_noise();
    loop_ = new ClosedLoop(options);
    ASSERT_TRUE(loop_->fly_to_hover(5));
    loop_->go_to(6, -4, 5, 0.7F);
    loop_->run(12);
    loop_->forget_packets();
    loop_->run(kWindow_s);
  }
  static void TearDownTestSuite() {
    delete loop_;
    loop_ = nullptr;
  }
  template <class Message>
  static Message last() {
    const auto all = loop_->received<Message>();
    EXPECT_FALSE(all.empty()) << Message::kName;
    return all.empty() ? Message{} : all.back();
  }
  template <class Message>
  static double count() {
    return static_cast<double>(loop_->received<Message>().size());
  }
  static constexpr double kWindow_s = 4;
  static constexpr double kNear_m = 0.1;
  static inline ClosedLoop* loop_ = nullptr;
};

TEST_F(Telemetry, RatesAreTheUsualOnes) {
  EXPECT_NEAR(count<Heartbeat>(), kWindow_s, 1);
  EXPECT_NEAR(count<Attitude>(), 50 * kWindow_s, 2);
  EXPECT_NEAR(count<LocalPositionNed>(), 30 * kWindow_s, 2);
  EXPECT_NEAR(count<GlobalPositionInt>(), 5 * kWindow_s, 1);
  EXPECT_NEAR(count<SysStatus>(), kWindow_s, 1);
  EXPECT_NEAR(count<CurrentMode>(), 0.5 * kWindow_s, 1);
}

TEST_F(Telemetry, TellsOfNoBreachOfAFenceThatIsNotThere) {
  using mavlink::common::MavSysStatusSensor;
  const auto m = last<SysStatus>();
  EXPECT_FALSE(has(m.onboard_control_sensors_present, MavSysStatusSensor::kGeofence));
  EXPECT_TRUE(has(m.onboard_control_sensors_health, MavSysStatusSensor::kGeofence));
}

TEST_F(Telemetry, AttitudeIsInRadians) {
  const auto m = last<Attitude>();
  const Eigen::Vector3d rpy = base::euler_rpy(loop_->truth().q_ND);
  EXPECT_NEAR(m.roll, rpy.x(), 0.02);
  EXPECT_NEAR(m.pitch, rpy.y(), 0.02);
  EXPECT_NEAR(m.yaw, 0.7, 0.03);
  EXPECT_NEAR(m.yawspeed, loop_->truth().w_D.z(), 0.05);
  EXPECT_NEAR(m.time_boot_ms, 1000 * loop_->time_s(), 40);
  const auto q = last<AttitudeQuaternion>();
  EXPECT_NEAR(std::hypot(q.q1, q.q4), 1, 0.01);  // level: w and z
  EXPECT_NEAR(2 * std::atan2(q.q4, q.q1), 0.7, 0.03);
  const auto target = last<AttitudeTarget>();
  EXPECT_NEAR(2 * std::atan2(target.q[3], target.q[0]), 0.7, 0.03);
  EXPECT_NEAR(target.thrust, 0.54, 0.05);  // weight over full thrust
}

TEST_F(Telemetry, LocalPositionIsNorthEastDownInMetres) {
  const auto m = last<LocalPositionNed>();
  EXPECT_NEAR(m.x, 6, kNear_m);
  EXPECT_NEAR(m.y, -4, kNear_m);
  EXPECT_NEAR(m.z, -5, kNear_m);
  EXPECT_NEAR(m.vx, 0, 0.1);
  const auto target = last<PositionTargetLocalNed>();
  EXPECT_NEAR(target.x, 6, 0.01);
  EXPECT_NEAR(target.y, -4, 0.01);
  EXPECT_NEAR(target.z, -5, 0.01);
  EXPECT_NEAR(target.yaw, 0.7, 0.01);
}

TEST_F(Telemetry, GlobalPositionIsInDegreesE7AndMillimetres) {
  const base::Geodetic place = base::LocalProjection(loop_->home()).to_geodetic({6, -4, -5});
  const auto m = last<GlobalPositionInt>();
  EXPECT_NEAR(m.lat, place.lat_deg * 1e7, 15);
  EXPECT_NEAR(m.lon, place.lon_deg * 1e7, 15);
  EXPECT_NEAR(m.alt, 493'000, 1000 * kNear_m);
  EXPECT_NEAR(m.relative_alt, 5000, 1000 * kNear_m);
  EXPECT_NEAR(m.hdg, 100 * 0.7 * 180 / M_PI, 200);
  EXPECT_NEAR(m.vx, 0, 10);  // cm/s
}

TEST_F(Telemetry, GpsIsPassedOnWithItsAccuracies) {
  const auto m = last<GpsRawInt>();
  EXPECT_EQ(m.fix_type, GpsFixType::k3dFix);
  EXPECT_NEAR(m.lat, 473'977'420 + 6 / 0.0111319, 20);
  EXPECT_NEAR(m.alt, 493'000, 200);
  EXPECT_EQ(m.satellites_visible, 12);
  EXPECT_EQ(m.eph, 100);
  EXPECT_NEAR(m.h_acc, 10, 1);  // mm, from the RTK parameters
}

TEST_F(Telemetry, HudAndAltitudesAreAboveSeaAndAboveHome) {
  const auto hud = last<VfrHud>();
  EXPECT_NEAR(hud.alt, 493, kNear_m);
  EXPECT_NEAR(hud.heading, 0.7 * 180 / M_PI, 2);
  EXPECT_NEAR(hud.throttle, 54, 5);
  EXPECT_NEAR(hud.climb, 0, 0.1);
  const auto m = last<mavlink::common::Altitude>();
  EXPECT_NEAR(m.altitude_amsl, 493, kNear_m);
  EXPECT_NEAR(m.altitude_local, 5, kNear_m);
  EXPECT_NEAR(m.altitude_relative, 5, kNear_m);
  EXPECT_NEAR(m.altitude_monotonic, 493, 1);
  EXPECT_TRUE(std::isnan(m.altitude_terrain));
}

TEST_F(Telemetry, HomeIsWhereItTookOff) {
  const auto m = last<HomePosition>();
  EXPECT_NEAR(m.latitude, 473'977'420, 20);
  EXPECT_NEAR(m.longitude, 85'455'940, 20);
  EXPECT_NEAR(m.altitude, 488'000, 1000 * kNear_m);
  EXPECT_NEAR(m.z, 0, kNear_m);
  loop_->command(MavCmd::kRequestMessage, {static_cast<float>(GpsGlobalOrigin::kId)});
  const auto origin = last<GpsGlobalOrigin>();
  EXPECT_NEAR(origin.latitude, 473'977'420, 1);
  EXPECT_NEAR(origin.altitude, 488'000, 1);
}

TEST_F(Telemetry, StatesAreThoseOfAFlight) {
  const auto beat = last<Heartbeat>();
  EXPECT_TRUE(has(beat.base_mode, MavModeFlag::kSafetyArmed));
  EXPECT_EQ(beat.system_status, MavState::kActive);
  EXPECT_EQ(beat.custom_mode, 4U << 16U | 3U << 24U);
  EXPECT_EQ(last<ExtendedSysState>().landed_state, MavLandedState::kInAir);
  EXPECT_EQ(last<CurrentMode>().custom_mode, beat.custom_mode);
  EXPECT_EQ(last<MissionCurrent>().mission_state, MissionState::kNoMission);
  EXPECT_NEAR(last<SystemTime>().time_boot_ms, 1000 * loop_->time_s(), 1100);
}

TEST_F(Telemetry, HealthAndBatteryAreGood) {
  using S = MavSysStatusSensor;
  const auto m = last<SysStatus>();
  for (const S s : {S::k3dGyro, S::k3dAccel, S::k3dMag, S::kAbsolutePressure, S::kGps, S::kAhrs,
                    S::kPrearmCheck, S::kBattery}) {
    EXPECT_TRUE(has(m.onboard_control_sensors_present, s)) << static_cast<std::uint32_t>(s);
    EXPECT_TRUE(has(m.onboard_control_sensors_enabled, s)) << static_cast<std::uint32_t>(s);
    EXPECT_TRUE(has(m.onboard_control_sensors_health, s)) << static_cast<std::uint32_t>(s);
  }
  EXPECT_NEAR(m.voltage_battery, 16'200, 200);  // mV, four full cells
  EXPECT_NEAR(m.current_battery, 1000, 1);      // cA
  EXPECT_NEAR(m.battery_remaining, 97, 3);
  const auto battery = last<BatteryStatus>();
  EXPECT_NEAR(battery.voltages[0], 4050, 50);
  EXPECT_EQ(battery.voltages[4], 0xFFFF);
  EXPECT_EQ(battery.charge_state, MavBatteryChargeState::kOk);
  EXPECT_GT(battery.current_consumed, 0);
}

TEST_F(Telemetry, EstimatorTellsItsAccuracyAndItsGates) {
  using E = EstimatorStatusFlags;
  const auto m = last<EstimatorStatus>();
  for (const E e : {E::kAttitude, E::kVelocityHoriz, E::kPosHorizAbs, E::kPosVertAbs}) {
    EXPECT_TRUE(has(m.flags, e)) << static_cast<std::uint32_t>(e);
  }
  EXPECT_FALSE(has(m.flags, E::kConstPosMode));
  EXPECT_FALSE(has(m.flags, E::kGpsGlitch));
  EXPECT_GT(m.pos_horiz_accuracy, 0.001);
  EXPECT_LT(m.pos_horiz_accuracy, 0.05);
  EXPECT_LT(m.vel_ratio, 1);
  EXPECT_LT(m.mag_ratio, 1);
  const auto vibration = last<Vibration>();
  EXPECT_NEAR(vibration.vibration_z, loop_->noise().accel_m_s2.z(), 0.3);
}

TEST_F(Telemetry, OutputsAndPressureAreInTheirUnits) {
  const auto servo = last<ServoOutputRaw>();
  for (const auto pwm : {servo.servo1_raw, servo.servo2_raw, servo.servo3_raw, servo.servo4_raw}) {
    EXPECT_GT(pwm, 1400);
    EXPECT_LT(pwm, 1900);
  }
  EXPECT_EQ(servo.servo5_raw, 0);
  loop_->command(MavCmd::kRequestMessage, {static_cast<float>(ScaledPressure::kId)});
  EXPECT_NEAR(last<ScaledPressure>().press_abs, 955.5, 0.5);  // hPa at 493 m
}

TEST(Health, FallsWithASensorThatFallsSilent) {
  struct SilentSensor {
    const char* name;
    bool ClosedLoop::*sensor;
    MavSysStatusSensor bit;
  };
  const SilentSensor rows[] = {
      {"Imu", &ClosedLoop::imu_on, MavSysStatusSensor::k3dGyro},
      {"Mag", &ClosedLoop::mag_on, MavSysStatusSensor::k3dMag},
      {"Baro", &ClosedLoop::baro_on, MavSysStatusSensor::kAbsolutePressure},
      {"Gps", &ClosedLoop::gps_on, MavSysStatusSensor::kGps}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    using S = MavSysStatusSensor;
    ClosedLoop loop{LoopOptions{}};
    loop.run(12);
    const auto before = loop.received<SysStatus>();
    ASSERT_FALSE(before.empty());
    EXPECT_TRUE(has(before.back().onboard_control_sensors_health, row.bit));
    EXPECT_TRUE(has(before.back().onboard_control_sensors_health, S::kPrearmCheck));
    loop.*row.sensor = false;
    loop.run(4);
    const auto health = loop.received<SysStatus>().back().onboard_control_sensors_health;
    EXPECT_FALSE(has(health, row.bit));
    EXPECT_FALSE(has(health, S::kPrearmCheck));
  }
}

/// Ten seconds at rest behind a line of this rate.
class TelemetryOnALine : public testing::Test {
 protected:
  void listen(double baud, double control_rate_hz) {
    LoopOptions options;
    options.configure = [&](FcuConfig& config) {
      config.line.baud = baud;
      config.control_rate_hz = control_rate_hz;
    };
    ClosedLoop loop(options);
    loop.run(3);
    const auto before = loop.fcu().stats().sent;
    loop.run(kTime_s);
    for (auto [name, count] : loop.fcu().stats().sent) {
      const auto found = before.find(name);
      if (found != before.end()) count -= found->second;
      rate_hz_[name] = static_cast<double>(count) / kTime_s;
      constexpr int kAroundPayload = 12;
      const double bytes = table().find(std::string_view(name))->min_length + kAroundPayload;
      (name == "HIL_CONTROLS" ? controls_b_s_ : telemetry_b_s_) += rate_hz_[name] * bytes;
    }
  }

  static constexpr double kTime_s = 10;
  std::map<std::string, double> rate_hz_;
  double controls_b_s_ = 0;
  double telemetry_b_s_ = 0;
};

TEST_F(TelemetryOnALine, IsWholeOnTheUsualOne) {
  listen(921600, 400);
  EXPECT_NEAR(rate_hz_["HIL_CONTROLS"], 400, 1);
  EXPECT_NEAR(rate_hz_["ATTITUDE"], 50, 0.3);
  EXPECT_NEAR(rate_hz_["LOCAL_POSITION_NED"], 30, 0.3);
}

TEST_F(TelemetryOnALine, TakesHalfOfWhatTheControlsLeaveOfASlowOne) {
  listen(57600, 50);
  EXPECT_NEAR(rate_hz_["HIL_CONTROLS"], 50, 0.2);
  EXPECT_LE(telemetry_b_s_, 1.02 * 0.5 * (5760 - controls_b_s_));
  EXPECT_GE(telemetry_b_s_, 0.7 * 0.5 * (5760 - controls_b_s_));
  constexpr double kWaiting = 0.2;  // for each other's packets, some tenths of an interval
  EXPECT_NEAR(rate_hz_["ATTITUDE"] / rate_hz_["LOCAL_POSITION_NED"], 50.0 / 30, kWaiting);
  EXPECT_NEAR(rate_hz_["HEARTBEAT"], 1, 0.1) << "a ground station lives on it";
  EXPECT_NEAR(rate_hz_["SYS_STATUS"], 1, 0.1);
}

/// Controls of the configured 400 Hz alone are too much for it.
TEST_F(TelemetryOnALine, IsATwentiethAtLeast) {
  listen(57600, 400);
  EXPECT_NEAR(rate_hz_["HIL_CONTROLS"], 400, 1);
  EXPECT_NEAR(rate_hz_["ATTITUDE"], 50 / 20.0, 0.3);
  EXPECT_GT(rate_hz_["HEARTBEAT"], 0.5);
}

}  // namespace
}  // namespace cas::fcu
