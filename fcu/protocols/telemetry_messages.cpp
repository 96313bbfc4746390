// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/telemetry_messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/earth/frames.hpp"
#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/wire_units.hpp"
#include "mavlink/common/altitude.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/attitude_quaternion.hpp"
#include "mavlink/common/attitude_target.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/available_modes.hpp"
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
#include "mavlink/common/protocol_version.hpp"
#include "mavlink/common/scaled_pressure.hpp"
#include "mavlink/common/servo_output_raw.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink/common/system_time.hpp"
#include "mavlink/common/vfr_hud.hpp"
#include "mavlink/common/vibration.hpp"
#include "mavlink_gen/runtime/message.hpp"

namespace cas::fcu {

using base::RunTime;
using Eigen::Vector3d;
using namespace mavlink::common;  // NOLINT: the file is about its messages

// Where the vehicle is, and where it is going.

namespace {

double amsl(const FcuCore& core, double z) {
  return (core.estimator.projection() ? core.estimator.projection()->home().alt_m : 0.0) - z;
}

}  // namespace

void send_attitude(FcuCore& core, RunTime now, int version) {
  const EstimatorState& s = core.estimator.state();
  const Vector3d rpy = base::euler_rpy(s.q_ND);
  core.outbox.reply(
      Attitude{core.time_boot_ms(now), to_float(rpy.x()), to_float(rpy.y()), to_float(rpy.z()),
               to_float(s.w_D.x()), to_float(s.w_D.y()), to_float(s.w_D.z())},
      version);
}

void send_attitude_quaternion(FcuCore& core, RunTime now, int version) {
  const EstimatorState& s = core.estimator.state();
  AttitudeQuaternion m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.q1 = to_float(s.q_ND.w());
  m.q2 = to_float(s.q_ND.x());
  m.q3 = to_float(s.q_ND.y());
  m.q4 = to_float(s.q_ND.z());
  m.rollspeed = to_float(s.w_D.x());
  m.pitchspeed = to_float(s.w_D.y());
  m.yawspeed = to_float(s.w_D.z());
  core.outbox.reply(m, version);
}

void send_attitude_target(FcuCore& core, RunTime now, int version) {
  if (!core.commander.flying()) return;
  const AttitudeSetpoint& s = core.cascade.attitude_setpoint();
  const Vector3d& w = core.cascade.rate_setpoint();
  AttitudeTarget m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.q = {to_float(s.q_ND.w()), to_float(s.q_ND.x()), to_float(s.q_ND.y()), to_float(s.q_ND.z())};
  m.body_roll_rate = to_float(w.x());
  m.body_pitch_rate = to_float(w.y());
  m.body_yaw_rate = to_float(w.z());
  m.thrust = to_float(s.thrust_n / core.config.vehicle.scales.u1_max_n);
  core.outbox.reply(m, version);
}

void send_local_position(FcuCore& core, RunTime now, int version) {
  if (!core.estimator.projection()) return;
  const EstimatorState& s = core.estimator.state();
  core.outbox.reply(LocalPositionNed{core.time_boot_ms(now), to_float(s.p_N.x()),
                                     to_float(s.p_N.y()), to_float(s.p_N.z()), to_float(s.v_N.x()),
                                     to_float(s.v_N.y()), to_float(s.v_N.z())},
                    version);
}

void send_position_target(FcuCore& core, RunTime now, int version) {
  const ControlSetpoint& setpoint = core.commander.setpoint();
  if (!setpoint.trajectory) return;
  const TrajectorySetpoint& t = *setpoint.trajectory;
  PositionTargetLocalNed m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.coordinate_frame = MavFrame::kLocalNed;
  m.x = to_float(t.p_N.x());
  m.y = to_float(t.p_N.y());
  m.z = to_float(t.p_N.z());
  m.vx = to_float(t.v_N.x());
  m.vy = to_float(t.v_N.y());
  m.vz = to_float(t.v_N.z());
  m.afx = to_float(t.a_N.x());
  m.afy = to_float(t.a_N.y());
  m.afz = to_float(t.a_N.z());
  m.yaw = to_float(t.yaw_rad);
  m.yaw_rate = to_float(t.yaw_rate_rad_s);
  core.outbox.reply(m, version);
}

void send_global_position(FcuCore& core, RunTime now, int version) {
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

void send_vfr_hud(FcuCore& core, RunTime, int version) {
  const EstimatorState& s = core.estimator.state();
  VfrHud m;
  m.groundspeed = to_float(s.v_N.head<2>().norm());
  m.airspeed = m.groundspeed;
  m.heading = static_cast<std::int16_t>(heading_cdeg(base::euler_rpy(s.q_ND).z()) / 100);
  const double throttle = core.cascade.output().u[0] / core.config.vehicle.scales.u1_max_n;
  m.throttle = static_cast<std::uint16_t>(std::lround(100 * std::clamp(throttle, 0.0, 1.0)));
  m.alt = to_float(amsl(core, s.p_N.z()));
  m.climb = to_float(-s.v_N.z());
  core.outbox.reply(m, version);
}

void send_altitude(FcuCore& core, RunTime now, int version) {
  const EstimatorState& s = core.estimator.state();
  mavlink::common::Altitude m;
  m.time_usec = core.time_boot_us(now);
  m.altitude_amsl = to_float(amsl(core, s.p_N.z()));
  m.altitude_monotonic = to_float(amsl(core, s.p_N.z()) + s.baro_offset_m);
  m.altitude_local = to_float(-s.p_N.z());
  m.altitude_relative = to_float(core.home_N.z() - s.p_N.z());
  m.altitude_terrain = to_float(kUnset);
  m.bottom_clearance = to_float(kUnset);
  core.outbox.reply(m, version);
}

void send_home_position(FcuCore& core, RunTime now, int version) {
  if (!core.home_set || !core.estimator.projection()) return;
  const base::Geodetic place = core.estimator.projection()->to_geodetic(core.home_N);
  const Eigen::Quaterniond q = base::quaternion_rpy(0, 0, core.home_yaw_rad);
  HomePosition m;
  m.latitude = deg_e7(place.lat_deg);
  m.longitude = deg_e7(place.lon_deg);
  m.altitude = milli(place.alt_m);
  m.x = to_float(core.home_N.x());
  m.y = to_float(core.home_N.y());
  m.z = to_float(core.home_N.z());
  m.q = {to_float(q.w()), to_float(q.x()), to_float(q.y()), to_float(q.z())};
  m.approach_x = m.approach_y = m.approach_z = to_float(kUnset);
  m.time_usec = core.time_boot_us(now);
  core.outbox.reply(m, version);
}

void send_gps_global_origin(FcuCore& core, RunTime now, int version) {
  if (!core.estimator.origin_final()) return;
  const base::Geodetic& origin = core.estimator.projection()->home();
  core.outbox.reply(GpsGlobalOrigin{deg_e7(origin.lat_deg), deg_e7(origin.lon_deg),
                                    milli(origin.alt_m), core.time_boot_us(now)},
                    version);
}

// How the vehicle and its parts are.

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
  const auto alive = [&](SensorHealth::Sensor s) { return core.sensors.alive(s, now); };
  // Nothing breaches a fence that is not there; a ground station (MAVProxy) takes less for a
  // breach.
  S health = S::kMotorOutputs | S::kBattery | S::kGeofence;
  if (alive(SensorHealth::kImu)) health |= S::k3dGyro | S::k3dAccel | S::kAngularRateControl;
  if (alive(SensorHealth::kMag)) health |= S::k3dMag;
  if (alive(SensorHealth::kBaro)) health |= S::kAbsolutePressure;
  if (alive(SensorHealth::kGps)) health |= S::kGps;
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
  m.fix_type = core.sensors.alive(SensorHealth::kGps, now) ? static_cast<GpsFixType>(g.fix_type)
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
  const Mixer& mixer = core.cascade.mixer();
  const auto outputs = mixer.outputs(core.cascade.output());
  const auto pwm = [&](std::size_t i) -> std::uint16_t {
    const OutputKind kind = mixer.output_kind(i);
    if (kind == OutputKind::kNothing) return 0;
    if (kind == OutputKind::kServo) {
      return static_cast<std::uint16_t>(1500 + std::lround(500 * outputs[i]));
    }
    return static_cast<std::uint16_t>(core.commander.armed() ? 1000 + std::lround(1000 * outputs[i])
                                                             : 900);
  };
  ServoOutputRaw m;
  m.time_usec = static_cast<std::uint32_t>(core.time_boot_us(now));
  std::uint16_t* const fields[] = {&m.servo1_raw,  &m.servo2_raw,  &m.servo3_raw,  &m.servo4_raw,
                                   &m.servo5_raw,  &m.servo6_raw,  &m.servo7_raw,  &m.servo8_raw,
                                   &m.servo9_raw,  &m.servo10_raw, &m.servo11_raw, &m.servo12_raw,
                                   &m.servo13_raw, &m.servo14_raw, &m.servo15_raw, &m.servo16_raw};
  for (std::size_t i = 0; i < std::size(fields); ++i) *fields[i] = pwm(i);
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

// Version and modes.

namespace {

struct ModeInfo {
  FlightMode mode;
  MavStandardMode standard;
  const char* title;
};

constexpr std::array<ModeInfo, 9> kModes{{
    {FlightMode::kPosition, MavStandardMode::kPositionHold, "Position"},
    {FlightMode::kAltitude, MavStandardMode::kAltitudeHold, "Altitude"},
    {FlightMode::kStabilized, MavStandardMode::kNonStandard, "Stabilized"},
    {FlightMode::kTakeoff, MavStandardMode::kTakeoff, "Takeoff"},
    {FlightMode::kHold, MavStandardMode::kNonStandard, "Hold"},
    {FlightMode::kMission, MavStandardMode::kMission, "Mission"},
    {FlightMode::kReturn, MavStandardMode::kSafeRecovery, "Return"},
    {FlightMode::kLand, MavStandardMode::kLand, "Land"},
    {FlightMode::kOffboard, MavStandardMode::kNonStandard, "Offboard"},
}};

}  // namespace

void send_autopilot_version(FcuCore& core, base::RunTime, int version) {
  using C = MavProtocolCapability;
  AutopilotVersion m;
  m.capabilities = C::kMissionInt | C::kParamFloat | C::kCommandInt | C::kParamEncodeBytewise |
                   C::kSetAttitudeTarget | C::kSetPositionTargetLocalNed |
                   C::kSetPositionTargetGlobalInt | C::kFlightTermination | C::kMavlink2;
  // major, minor, patch, FIRMWARE_VERSION_TYPE_OFFICIAL: a release that ground stations know the
  // modes and parameters of.
  m.flight_sw_version = 1U << 24U | 15U << 16U | 0U << 8U | 255U;
  m.uid = core.config.system_id;
  core.outbox.reply(m, version);
}

void send_protocol_version(FcuCore& core, base::RunTime, int version) {
  ProtocolVersion m;
  m.version = 200;
  m.min_version = 100;
  m.max_version = 200;
  core.outbox.reply(m, version);
}

void send_available_modes(FcuCore& core, base::RunTime, int version) {
  for (std::size_t i = 0; i < kModes.size(); ++i) {
    AvailableModes m;
    m.number_modes = static_cast<std::uint8_t>(kModes.size());
    m.mode_index = static_cast<std::uint8_t>(i + 1);
    m.standard_mode = kModes[i].standard;
    m.custom_mode = px4_custom_mode(kModes[i].mode);
    mav::set_text(m.mode_name, kModes[i].title);
    core.outbox.reply(m, version);
  }
}

void send_current_mode(FcuCore& core, base::RunTime, int version) {
  CurrentMode m;
  for (const ModeInfo& info : kModes) {
    if (info.mode == core.commander.mode()) m.standard_mode = info.standard;
  }
  m.custom_mode = px4_custom_mode(core.commander.mode());
  m.intended_custom_mode = m.custom_mode;
  core.outbox.reply(m, version);
}

}  // namespace cas::fcu
