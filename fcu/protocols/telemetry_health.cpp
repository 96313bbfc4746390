// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/telemetry_health.hpp"

#include <algorithm>
#include <cmath>

#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/wire_units.hpp"
#include "mavlink/common/battery_status.hpp"
#include "mavlink/common/estimator_status.hpp"
#include "mavlink/common/extended_sys_state.hpp"
#include "mavlink/common/gps_raw_int.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/mission_current.hpp"
#include "mavlink/common/scaled_pressure.hpp"
#include "mavlink/common/servo_output_raw.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink/common/system_time.hpp"
#include "mavlink/common/vibration.hpp"

namespace cas::fcu {

using base::RunTime;
using Eigen::Vector3d;
using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

MavState system_state(const FcuCore& core) {
  if (core.commander.mode() == FlightMode::kTermination) return MavState::kFlightTermination;
  if (!core.estimator.aligned()) return MavState::kBoot;
  if (core.commander.armed() && core.commander.failsafe_active()) return MavState::kCritical;
  return core.commander.armed() ? MavState::kActive : MavState::kStandby;
}

/// The arming checks' verdict.
bool ready_to_arm(const FcuCore& core, RunTime now) {
  return !reason_not_to_arm(core.arming_input(now)).has_value();
}

}  // namespace

void send_heartbeat(FcuCore& core, RunTime, int version) {
  const FlightMode mode = core.commander.mode();
  Heartbeat m;
  m.type = static_cast<MavType>(core.params.get_int("MAV_TYPE"));
  m.autopilot = MavAutopilot::kPx4;
  m.base_mode =
      MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled | MavModeFlag::kStabilizeEnabled;
  if (core.commander.armed()) m.base_mode |= MavModeFlag::kSafetyArmed;
  if (is_manual(mode)) {
    m.base_mode |= MavModeFlag::kManualInputEnabled;
  } else {
    m.base_mode |= MavModeFlag::kAutoEnabled | MavModeFlag::kGuidedEnabled;
  }
  m.custom_mode = px4_custom_mode(mode);
  m.system_status = system_state(core);
  m.mavlink_version = 3;
  core.outbox.reply(m, version);
}

void send_sys_status(FcuCore& core, RunTime now, int version) {
  using S = MavSysStatusSensor;
  SysStatus m;
  const S always = S::k3dGyro | S::k3dAccel | S::k3dMag | S::kAbsolutePressure | S::kGps |
                   S::kAngularRateControl | S::kAttitudeStabilization | S::kYawPosition |
                   S::kZAltitudeControl | S::kXyPositionControl | S::kMotorOutputs | S::kAhrs |
                   S::kBattery | S::kPrearmCheck;
  m.onboard_control_sensors_present = always;
  m.onboard_control_sensors_enabled = always;
  const auto alive = [&](SensorMonitor::Sensor s) { return core.sensors.alive(s, now); };
  S health = S::kMotorOutputs | S::kBattery;
  if (alive(SensorMonitor::kImu)) health |= S::k3dGyro | S::k3dAccel | S::kAngularRateControl;
  if (alive(SensorMonitor::kMag)) health |= S::k3dMag;
  if (alive(SensorMonitor::kBaro)) health |= S::kAbsolutePressure;
  if (alive(SensorMonitor::kGps)) health |= S::kGps;
  if (core.estimator.aligned()) health |= S::kAhrs | S::kAttitudeStabilization;
  if (core.estimator.heading_valid()) health |= S::kYawPosition;
  if (core.estimator.height_valid()) health |= S::kZAltitudeControl;
  if (core.estimator.position_valid()) health |= S::kXyPositionControl;
  if (ready_to_arm(core, now)) health |= S::kPrearmCheck;
  m.onboard_control_sensors_health = health;
  m.load = 0;  // not measured
  m.voltage_battery = static_cast<std::uint16_t>(1000 * core.battery.voltage_v());
  m.current_battery = centi(core.battery.current_a(core.commander.armed()));
  m.battery_remaining = static_cast<std::int8_t>(std::lround(100 * core.battery.remaining()));
  core.outbox.reply(m, version);
}

void send_extended_sys_state(FcuCore& core, RunTime, int version) {
  ExtendedSysState m;
  m.vtol_state = MavVtolState::kUndefined;
  switch (core.commander.landed()) {
    case LandedState::kOnGround:
      m.landed_state = MavLandedState::kOnGround;
      break;
    case LandedState::kTakingOff:
      m.landed_state = MavLandedState::kTakeoff;
      break;
    case LandedState::kInAir:
      m.landed_state = MavLandedState::kInAir;
      break;
    case LandedState::kLanding:
      m.landed_state = MavLandedState::kLanding;
      break;
  }
  core.outbox.reply(m, version);
}

void send_battery_status(FcuCore& core, RunTime, int version) {
  constexpr std::uint16_t kNoCell = 0xFFFF;
  const int cells = core.params.get_int("BAT1_N_CELLS");
  BatteryStatus m;
  m.battery_function = MavBatteryFunction::kAll;
  m.type = MavBatteryType::kLipo;
  m.temperature = 0x7FFF;
  m.voltages.fill(kNoCell);
  for (int i = 0; i < std::min(cells, 10); ++i) {
    m.voltages[static_cast<std::size_t>(i)] =
        static_cast<std::uint16_t>(1000 * core.battery.voltage_v() / cells);
  }
  m.current_battery = centi(core.battery.current_a(core.commander.armed()));
  m.current_consumed = static_cast<std::int32_t>(core.battery.consumed_mah());
  m.energy_consumed = -1;
  m.battery_remaining = static_cast<std::int8_t>(std::lround(100 * core.battery.remaining()));
  const double left = core.battery.remaining();
  m.charge_state = left < core.flight.battery_emergency  ? MavBatteryChargeState::kEmergency
                   : left < core.flight.battery_critical ? MavBatteryChargeState::kCritical
                   : left < core.flight.battery_low      ? MavBatteryChargeState::kLow
                                                         : MavBatteryChargeState::kOk;
  core.outbox.reply(m, version);
}

void send_estimator_status(FcuCore& core, RunTime now, int version) {
  using E = EstimatorStatusFlags;
  const Estimator& e = core.estimator;
  EstimatorStatus m;
  m.time_usec = core.time_boot_us(now);
  if (e.aligned()) m.flags |= E::kAttitude;
  if (e.velocity_valid()) m.flags |= E::kVelocityHoriz;
  if (e.height_valid()) m.flags |= E::kVelocityVert | E::kPosVertAbs;
  if (e.position_valid()) {
    m.flags |= E::kPosHorizRel | E::kPosHorizAbs | E::kPredPosHorizRel | E::kPredPosHorizAbs;
  } else {
    m.flags |= E::kConstPosMode;
  }
  if (e.gps_position().test_ratio > 1) m.flags |= E::kGpsGlitch;
  m.vel_ratio = to_float(std::sqrt(e.gps_velocity().test_ratio));
  m.pos_horiz_ratio = to_float(std::sqrt(e.gps_position().test_ratio));
  m.pos_vert_ratio = to_float(std::sqrt(e.baro().test_ratio));
  m.mag_ratio = to_float(std::sqrt(e.mag().test_ratio));
  const Vector3d deviation = e.covariance().deviation(ErrorCovariance::kPosition);
  m.pos_horiz_accuracy = to_float(std::hypot(deviation.x(), deviation.y()));
  m.pos_vert_accuracy = to_float(deviation.z());
  core.outbox.reply(m, version);
}

void send_vibration(FcuCore& core, RunTime now, int version) {
  const Vector3d v = core.vibration.square.cwiseMax(0.0).cwiseSqrt();
  core.outbox.reply(
      Vibration{core.time_boot_us(now), to_float(v.x()), to_float(v.y()), to_float(v.z()), 0, 0, 0},
      version);
}

void send_gps_raw(FcuCore& core, RunTime now, int version) {
  if (!core.last_gps) return;
  const HilGps& g = *core.last_gps;
  GpsRawInt m;
  m.time_usec = core.time_boot_us(now);
  m.fix_type = core.sensors.alive(SensorMonitor::kGps, now) ? static_cast<GpsFixType>(g.fix_type)
                                                            : GpsFixType::kNoGps;
  m.lat = g.lat;
  m.lon = g.lon;
  m.alt = g.alt;
  m.eph = g.eph;
  m.epv = g.epv;
  m.vel = g.vel;
  m.cog = g.cog;
  m.satellites_visible = g.satellites_visible;
  m.alt_ellipsoid = g.alt;
  m.h_acc = static_cast<std::uint32_t>(1000 * core.params.get("EKF2_GPS_P_NOISE"));
  m.v_acc = static_cast<std::uint32_t>(1000 * core.params.get("CAS_GPS_Z_NOISE"));
  m.vel_acc = static_cast<std::uint32_t>(1000 * core.params.get("EKF2_GPS_V_NOISE"));
  core.outbox.reply(m, version);
}

void send_scaled_pressure(FcuCore& core, RunTime now, int version) {
  ScaledPressure m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.press_abs = to_float(core.last_pressure_hpa);
  m.temperature = centi(core.last_temperature_degc);
  core.outbox.reply(m, version);
}

void send_servo_output_raw(FcuCore& core, RunTime now, int version) {
  const Eigen::Vector4d motors = core.cascade.mixer().motor_outputs(core.cascade.output().omega_sq);
  const auto pwm = [&](int i) {
    return static_cast<std::uint16_t>(core.commander.armed() ? 1000 + std::lround(1000 * motors[i])
                                                             : 900);
  };
  ServoOutputRaw m;
  m.time_usec = static_cast<std::uint32_t>(core.time_boot_us(now));
  m.servo1_raw = pwm(0);
  m.servo2_raw = pwm(1);
  m.servo3_raw = pwm(2);
  m.servo4_raw = pwm(3);
  core.outbox.reply(m, version);
}

void send_system_time(FcuCore& core, RunTime now, int version) {
  core.outbox.reply(SystemTime{0, core.time_boot_ms(now)}, version);
}

void send_mission_current(FcuCore& core, RunTime, int version) {
  const MissionTask& mission = core.commander.mission();
  const bool flown = core.commander.mode() == FlightMode::kMission;
  MissionCurrent m;
  m.seq = static_cast<std::uint16_t>(mission.current());
  m.total = static_cast<std::uint16_t>(mission.items().size());
  m.mission_state = mission.items().empty() ? MissionState::kNoMission
                    : mission.finished()    ? MissionState::kComplete
                    : flown                 ? MissionState::kActive
                                            : MissionState::kNotStarted;
  m.mission_mode = flown ? 1 : 2;
  core.outbox.reply(m, version);
}

}  // namespace cas::fcu
