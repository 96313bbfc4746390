// SPDX-License-Identifier: BSD-3-Clause
// What the controller says about itself, message by message.
#include "fcu/telemetry_messages.hpp"

#include <algorithm>
#include <cmath>

#include "base/frames.hpp"
#include "fcu/fcu_core.hpp"
#include "fcu/version_info.hpp"
#include "mavlink/common/altitude.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/attitude_quaternion.hpp"
#include "mavlink/common/attitude_target.hpp"
#include "mavlink/common/battery_status.hpp"
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
#include "mavlink/common/vfr_hud.hpp"
#include "mavlink/common/vibration.hpp"

namespace cas::fcu {

using base::RunTime;
using Eigen::Vector3d;
using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

float f(double value) { return static_cast<float>(value); }

std::int16_t centi(double value) {
  return static_cast<std::int16_t>(std::clamp(100 * value, -32767.0, 32767.0));
}

std::int32_t milli(double value) { return static_cast<std::int32_t>(std::lround(1000 * value)); }
std::int32_t deg_e7(double value) { return static_cast<std::int32_t>(std::llround(1e7 * value)); }

std::uint16_t heading_cdeg(double yaw_rad) {
  const double degrees = std::fmod(yaw_rad * 180 / M_PI + 360, 360);
  return static_cast<std::uint16_t>(std::lround(degrees * 100) % 36000);
}

double amsl(const FcuCore& core, double z) {
  return (core.estimator.projection() ? core.estimator.projection()->home().alt_m : 0.0) - z;
}

MavState system_state(const FcuCore& core) {
  if (core.commander.mode() == FlightMode::kTermination) return MavState::kFlightTermination;
  if (!core.estimator.aligned()) return MavState::kBoot;
  if (core.commander.armed() && core.commander.failsafe_active()) return MavState::kCritical;
  return core.commander.armed() ? MavState::kActive : MavState::kStandby;
}

void heartbeat(FcuCore& core, RunTime, int version) {
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

void sys_status(FcuCore& core, RunTime now, int version) {
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
  m.load = 100;  // per mille; the emulator measures no load
  m.voltage_battery = static_cast<std::uint16_t>(1000 * core.battery.voltage_v());
  m.current_battery = centi(core.battery.current_a(core.commander.armed()));
  m.battery_remaining = static_cast<std::int8_t>(std::lround(100 * core.battery.remaining()));
  core.outbox.reply(m, version);
}

void attitude(FcuCore& core, RunTime now, int version) {
  const EstimatorState& s = core.estimator.state();
  const Vector3d rpy = base::euler_rpy(s.q_ND);
  core.outbox.reply(Attitude{core.time_boot_ms(now), f(rpy.x()), f(rpy.y()), f(rpy.z()),
                             f(s.w_D.x()), f(s.w_D.y()), f(s.w_D.z())},
                    version);
}

void attitude_quaternion(FcuCore& core, RunTime now, int version) {
  const EstimatorState& s = core.estimator.state();
  AttitudeQuaternion m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.q1 = f(s.q_ND.w());
  m.q2 = f(s.q_ND.x());
  m.q3 = f(s.q_ND.y());
  m.q4 = f(s.q_ND.z());
  m.rollspeed = f(s.w_D.x());
  m.pitchspeed = f(s.w_D.y());
  m.yawspeed = f(s.w_D.z());
  core.outbox.reply(m, version);
}

void attitude_target(FcuCore& core, RunTime now, int version) {
  if (!core.commander.flying()) return;
  const AttitudeSetpoint& s = core.cascade.attitude_setpoint();
  const Vector3d& w = core.cascade.rate_setpoint();
  AttitudeTarget m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.q = {f(s.q_ND.w()), f(s.q_ND.x()), f(s.q_ND.y()), f(s.q_ND.z())};
  m.body_roll_rate = f(w.x());
  m.body_pitch_rate = f(w.y());
  m.body_yaw_rate = f(w.z());
  m.thrust = f(s.thrust_n / core.config.vehicle.scales.u1_max_n);
  core.outbox.reply(m, version);
}

void local_position(FcuCore& core, RunTime now, int version) {
  if (!core.estimator.projection()) return;
  const EstimatorState& s = core.estimator.state();
  core.outbox.reply(LocalPositionNed{core.time_boot_ms(now), f(s.p_N.x()), f(s.p_N.y()),
                                     f(s.p_N.z()), f(s.v_N.x()), f(s.v_N.y()), f(s.v_N.z())},
                    version);
}

void position_target(FcuCore& core, RunTime now, int version) {
  const ControlSetpoint& setpoint = core.commander.setpoint();
  if (!setpoint.trajectory) return;
  const TrajectorySetpoint& t = *setpoint.trajectory;
  PositionTargetLocalNed m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.coordinate_frame = MavFrame::kLocalNed;
  m.x = f(t.p_N.x());
  m.y = f(t.p_N.y());
  m.z = f(t.p_N.z());
  m.vx = f(t.v_N.x());
  m.vy = f(t.v_N.y());
  m.vz = f(t.v_N.z());
  m.afx = f(t.a_N.x());
  m.afy = f(t.a_N.y());
  m.afz = f(t.a_N.z());
  m.yaw = f(t.yaw_rad);
  m.yaw_rate = f(t.yaw_rate_rad_s);
  core.outbox.reply(m, version);
}

void global_position(FcuCore& core, RunTime now, int version) {
  if (!core.estimator.projection()) return;
  const EstimatorState& s = core.estimator.state();
  const base::Geodetic place = core.estimator.projection()->to_geodetic(s.p_N);
  GlobalPositionInt m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.lat = deg_e7(place.lat_deg);
  m.lon = deg_e7(place.lon_deg);
  m.alt = milli(place.alt_m);
  m.relative_alt = milli(core.home_N.z() - s.p_N.z());
  m.vx = centi(s.v_N.x());
  m.vy = centi(s.v_N.y());
  m.vz = centi(s.v_N.z());
  m.hdg = heading_cdeg(base::euler_rpy(s.q_ND).z());
  core.outbox.reply(m, version);
}

void gps_raw(FcuCore& core, RunTime now, int version) {
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

void vfr_hud(FcuCore& core, RunTime, int version) {
  const EstimatorState& s = core.estimator.state();
  VfrHud m;
  m.groundspeed = f(s.v_N.head<2>().norm());
  m.airspeed = m.groundspeed;
  m.heading = static_cast<std::int16_t>(heading_cdeg(base::euler_rpy(s.q_ND).z()) / 100);
  const double throttle = core.cascade.output().u[0] / core.config.vehicle.scales.u1_max_n;
  m.throttle = static_cast<std::uint16_t>(std::lround(100 * std::clamp(throttle, 0.0, 1.0)));
  m.alt = f(amsl(core, s.p_N.z()));
  m.climb = f(-s.v_N.z());
  core.outbox.reply(m, version);
}

void altitude(FcuCore& core, RunTime now, int version) {
  const EstimatorState& s = core.estimator.state();
  mavlink::common::Altitude m;
  m.time_usec = core.time_boot_us(now);
  m.altitude_amsl = f(amsl(core, s.p_N.z()));
  m.altitude_monotonic = f(amsl(core, s.p_N.z()) + s.baro_offset_m);
  m.altitude_local = f(-s.p_N.z());
  m.altitude_relative = f(core.home_N.z() - s.p_N.z());
  m.altitude_terrain = f(kUnset);
  m.bottom_clearance = f(kUnset);
  core.outbox.reply(m, version);
}

void vibration(FcuCore& core, RunTime now, int version) {
  const Vector3d v = core.vibration.square.cwiseMax(0.0).cwiseSqrt();
  core.outbox.reply(Vibration{core.time_boot_us(now), f(v.x()), f(v.y()), f(v.z()), 0, 0, 0},
                    version);
}

void estimator_status(FcuCore& core, RunTime now, int version) {
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
  m.vel_ratio = f(std::sqrt(e.gps_velocity().test_ratio));
  m.pos_horiz_ratio = f(std::sqrt(e.gps_position().test_ratio));
  m.pos_vert_ratio = f(std::sqrt(e.baro().test_ratio));
  m.mag_ratio = f(std::sqrt(e.mag().test_ratio));
  const Vector3d deviation = e.covariance().deviation(ErrorCovariance::kPosition);
  m.pos_horiz_accuracy = f(std::hypot(deviation.x(), deviation.y()));
  m.pos_vert_accuracy = f(deviation.z());
  core.outbox.reply(m, version);
}

void extended_sys_state(FcuCore& core, RunTime, int version) {
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

void battery_status(FcuCore& core, RunTime, int version) {
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

void home_position(FcuCore& core, RunTime now, int version) {
  if (!core.home_set || !core.estimator.projection()) return;
  const base::Geodetic place = core.estimator.projection()->to_geodetic(core.home_N);
  const Eigen::Quaterniond q = base::quaternion_rpy(0, 0, core.home_yaw_rad);
  HomePosition m;
  m.latitude = deg_e7(place.lat_deg);
  m.longitude = deg_e7(place.lon_deg);
  m.altitude = milli(place.alt_m);
  m.x = f(core.home_N.x());
  m.y = f(core.home_N.y());
  m.z = f(core.home_N.z());
  m.q = {f(q.w()), f(q.x()), f(q.y()), f(q.z())};
  m.approach_x = m.approach_y = m.approach_z = f(kUnset);
  m.time_usec = core.time_boot_us(now);
  core.outbox.reply(m, version);
}

void gps_global_origin(FcuCore& core, RunTime now, int version) {
  if (!core.estimator.origin_final()) return;
  const base::Geodetic& origin = core.estimator.projection()->home();
  core.outbox.reply(GpsGlobalOrigin{deg_e7(origin.lat_deg), deg_e7(origin.lon_deg),
                                    milli(origin.alt_m), core.time_boot_us(now)},
                    version);
}

void servo_output_raw(FcuCore& core, RunTime now, int version) {
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

void scaled_pressure(FcuCore& core, RunTime now, int version) {
  ScaledPressure m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.press_abs = f(core.last_pressure_hpa);
  m.temperature = centi(core.last_temperature_degc);
  core.outbox.reply(m, version);
}

void system_time(FcuCore& core, RunTime now, int version) {
  core.outbox.reply(SystemTime{0, core.time_boot_ms(now)}, version);
}

void mission_current(FcuCore& core, RunTime, int version) {
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

constexpr MessageSource kSources[] = {
    {Heartbeat::kId, 1, heartbeat},
    {SysStatus::kId, 1, sys_status},
    {Attitude::kId, 50, attitude},
    {AttitudeQuaternion::kId, 10, attitude_quaternion},
    {AttitudeTarget::kId, 2, attitude_target},
    {LocalPositionNed::kId, 30, local_position},
    {PositionTargetLocalNed::kId, 10, position_target},
    {GlobalPositionInt::kId, 5, global_position},
    {GpsRawInt::kId, 2, gps_raw},
    {VfrHud::kId, 4, vfr_hud},
    {mavlink::common::Altitude::kId, 1, altitude},
    {Vibration::kId, 0.5, vibration},
    {EstimatorStatus::kId, 1, estimator_status},
    {ExtendedSysState::kId, 1, extended_sys_state},
    {BatteryStatus::kId, 0.5, battery_status},
    {HomePosition::kId, 0.5, home_position},
    {GpsGlobalOrigin::kId, 0, gps_global_origin},
    {ServoOutputRaw::kId, 2, servo_output_raw},
    {ScaledPressure::kId, 0, scaled_pressure},
    {SystemTime::kId, 1, system_time},
    {MissionCurrent::kId, 1, mission_current},
    {AutopilotVersion::kId, 0, send_autopilot_version},
    {ProtocolVersion::kId, 0, send_protocol_version},
    {AvailableModes::kId, 0, send_available_modes},
    {CurrentMode::kId, 0.5, send_current_mode},
};

}  // namespace

std::span<const MessageSource> message_sources() { return kSources; }

bool ready_to_arm(const FcuCore& core, RunTime now) {
  return !reason_not_to_arm(core.arming_input(now)).has_value();
}

}  // namespace cas::fcu
