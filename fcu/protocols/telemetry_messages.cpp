// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/telemetry_messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/earth/frames.hpp"
#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/wire_units.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/message.hpp"

namespace cas::fcu {

using base::RunTime;
using Eigen::Vector3d;
using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

// Where the vehicle is, and where it is going.

double amsl(const FcuCore& core, double z) {
  return (core.estimator.projection() ? core.estimator.projection()->home().alt_m : 0.0) - z;
}

void send_attitude(const Report& r) {
  const EstimatorState& s = r.core.estimator.state();
  const Vector3d rpy = base::euler_rpy(s.q_ND);
  r.send(Attitude{r.core.time_boot_ms(r.now), to_float(rpy.x()), to_float(rpy.y()),
                  to_float(rpy.z()), to_float(s.w_D.x()), to_float(s.w_D.y()),
                  to_float(s.w_D.z())});
}

void send_attitude_quaternion(const Report& r) {
  const EstimatorState& s = r.core.estimator.state();
  AttitudeQuaternion m;
  m.time_boot_ms = r.core.time_boot_ms(r.now);
  m.q1 = to_float(s.q_ND.w());
  put(s.q_ND.vec(), m.q2, m.q3, m.q4);
  put(s.w_D, m.rollspeed, m.pitchspeed, m.yawspeed);
  r.send(m);
}

void send_attitude_target(const Report& r) {
  if (!r.core.commander.flying()) return;
  AttitudeSetpoint s = r.core.cascade.attitude_setpoint();
  Vector3d w = r.core.cascade.rate_setpoint();
  double thrust = s.thrust_n / r.core.config.vehicle.scales.u1_max_n;
  if (r.core.commander.on_wing()) {
    const WingController& wing = *r.core.wing;
    const double yaw = base::euler_rpy(r.core.estimator.state().q_ND).z();
    s.q_ND = base::quaternion_rpy(wing.roll_setpoint_rad(), wing.pitch_setpoint_rad(), yaw);
    w = wing.rate_setpoint();
    thrust = wing.throttle();
  }
  AttitudeTarget m;
  m.time_boot_ms = r.core.time_boot_ms(r.now);
  m.q = {to_float(s.q_ND.w()), to_float(s.q_ND.x()), to_float(s.q_ND.y()), to_float(s.q_ND.z())};
  put(w, m.body_roll_rate, m.body_pitch_rate, m.body_yaw_rate);
  m.thrust = to_float(thrust);
  r.send(m);
}

void send_local_position(const Report& r) {
  if (!r.core.estimator.projection()) return;
  const EstimatorState& s = r.core.estimator.state();
  r.send(LocalPositionNed{r.core.time_boot_ms(r.now), to_float(s.p_N.x()), to_float(s.p_N.y()),
                          to_float(s.p_N.z()), to_float(s.v_N.x()), to_float(s.v_N.y()),
                          to_float(s.v_N.z())});
}

void send_position_target(const Report& r) {
  const ControlSetpoint& setpoint = r.core.commander.setpoint();
  if (!setpoint.trajectory) return;
  const TrajectorySetpoint& t = *setpoint.trajectory;
  PositionTargetLocalNed m;
  m.time_boot_ms = r.core.time_boot_ms(r.now);
  m.coordinate_frame = MavFrame::kLocalNed;
  put(t.p_N, m.x, m.y, m.z);
  put(t.v_N, m.vx, m.vy, m.vz);
  put(t.a_N, m.afx, m.afy, m.afz);
  m.yaw = to_float(t.yaw_rad);
  m.yaw_rate = to_float(t.yaw_rate_rad_s);
  r.send(m);
}

void send_global_position(const Report& r) {
  if (!r.core.estimator.projection()) return;
  const EstimatorState& s = r.core.estimator.state();
  const base::Geodetic place = r.core.estimator.projection()->to_geodetic(s.p_N);
  GlobalPositionInt m;
  m.time_boot_ms = r.core.time_boot_ms(r.now);
  m.lat = deg_e7(place.lat_deg);
  m.lon = deg_e7(place.lon_deg);
  m.alt = milli(place.alt_m);
  m.relative_alt = milli(r.core.home.p_N.z() - s.p_N.z());
  m.vx = centi(s.v_N.x());
  m.vy = centi(s.v_N.y());
  m.vz = centi(s.v_N.z());
  m.hdg = heading_cdeg(base::euler_rpy(s.q_ND).z());
  r.send(m);
}

void send_vfr_hud(const Report& r) {
  const EstimatorState& s = r.core.estimator.state();
  VfrHud m;
  m.groundspeed = to_float(s.v_N.head<2>().norm());
  m.airspeed = m.groundspeed;
  m.heading = static_cast<std::int16_t>(heading_cdeg(base::euler_rpy(s.q_ND).z()) / 100);
  double throttle = r.core.cascade.output().u[0] / r.core.config.vehicle.scales.u1_max_n;
  if (r.core.commander.on_wing()) {
    m.airspeed =
        to_float(r.core.readings.airspeed.read(s.v_N.norm(), r.core.wing_params.use_airspeed, r.now)
                     .true_m_s);
    throttle = r.core.wing->throttle();
  }
  m.throttle = static_cast<std::uint16_t>(std::lround(100 * std::clamp(throttle, 0.0, 1.0)));
  m.alt = to_float(amsl(r.core, s.p_N.z()));
  m.climb = to_float(-s.v_N.z());
  r.send(m);
}

void send_altitude(const Report& r) {
  const EstimatorState& s = r.core.estimator.state();
  mavlink::common::Altitude m;
  m.time_usec = r.core.time_boot_us(r.now);
  m.altitude_amsl = to_float(amsl(r.core, s.p_N.z()));
  m.altitude_monotonic = to_float(amsl(r.core, s.p_N.z()) + s.baro_offset_m);
  m.altitude_local = to_float(-s.p_N.z());
  m.altitude_relative = to_float(r.core.home.p_N.z() - s.p_N.z());
  m.altitude_terrain = to_float(kUnset);
  m.bottom_clearance = to_float(kUnset);
  r.send(m);
}

void send_home_position(const Report& r) {
  if (!r.core.home.set || !r.core.estimator.projection()) return;
  const base::Geodetic place = r.core.estimator.projection()->to_geodetic(r.core.home.p_N);
  const Eigen::Quaterniond q = base::quaternion_rpy(0, 0, r.core.home.yaw_rad);
  HomePosition m;
  m.latitude = deg_e7(place.lat_deg);
  m.longitude = deg_e7(place.lon_deg);
  m.altitude = milli(place.alt_m);
  put(r.core.home.p_N, m.x, m.y, m.z);
  m.q = {to_float(q.w()), to_float(q.x()), to_float(q.y()), to_float(q.z())};
  m.approach_x = m.approach_y = m.approach_z = to_float(kUnset);
  m.time_usec = r.core.time_boot_us(r.now);
  r.send(m);
}

void send_gps_global_origin(const Report& r) {
  if (!r.core.estimator.origin_final()) return;
  const base::Geodetic& origin = r.core.estimator.projection()->home();
  r.send(GpsGlobalOrigin{deg_e7(origin.lat_deg), deg_e7(origin.lon_deg), milli(origin.alt_m),
                         r.core.time_boot_us(r.now)});
}

// How the vehicle and its parts are.

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

void send_heartbeat(const Report& r) {
  const FlightMode mode = r.core.commander.mode();
  Heartbeat m;
  m.type = static_cast<MavType>(r.core.params.get_int("MAV_TYPE"));
  m.autopilot = MavAutopilot::kPx4;
  m.base_mode =
      MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled | MavModeFlag::kStabilizeEnabled;
  if (r.core.commander.armed()) m.base_mode |= MavModeFlag::kSafetyArmed;
  if (is_manual(mode)) {
    m.base_mode |= MavModeFlag::kManualInputEnabled;
  } else {
    m.base_mode |= MavModeFlag::kAutoEnabled | MavModeFlag::kGuidedEnabled;
  }
  m.custom_mode = px4_custom_mode(mode);
  m.system_status = system_state(r.core);
  m.mavlink_version = 3;
  r.send(m);
}

/// The highest value of the field means unknown.
std::uint16_t millivolts(double voltage_v) {
  return static_cast<std::uint16_t>(std::clamp(1000 * voltage_v, 0.0, 65534.0));
}

std::int8_t percent(double share) { return static_cast<std::int8_t>(std::lround(100 * share)); }

void send_sys_status(const Report& r) {
  using S = MavSysStatusSensor;
  SysStatus m;
  const S always = S::k3dGyro | S::k3dAccel | S::k3dMag | S::kAbsolutePressure | S::kGps |
                   S::kAngularRateControl | S::kAttitudeStabilization | S::kYawPosition |
                   S::kZAltitudeControl | S::kXyPositionControl | S::kMotorOutputs | S::kAhrs |
                   S::kBattery | S::kPrearmCheck;
  const SensorHealth& sensors = r.core.readings.health;
  const S present = sensors.seen(SensorHealth::kOdometry) ? always | S::kVisionPosition : always;
  m.onboard_control_sensors_present = present;
  m.onboard_control_sensors_enabled = present;
  const auto alive = [&](SensorHealth::Sensor s) { return sensors.alive(s, r.now); };
  // Nothing breaches a fence that is not there; a ground station (MAVProxy) takes less for a
  // breach.
  S health = S::kMotorOutputs | S::kGeofence;
  if (alive(SensorHealth::kImu)) health |= S::k3dGyro | S::k3dAccel | S::kAngularRateControl;
  if (alive(SensorHealth::kMag)) health |= S::k3dMag;
  if (alive(SensorHealth::kBaro)) health |= S::kAbsolutePressure;
  if (alive(SensorHealth::kGps)) health |= S::kGps;
  if (alive(SensorHealth::kOdometry)) health |= S::kVisionPosition;
  if (r.core.estimator.aligned()) health |= S::kAhrs | S::kAttitudeStabilization;
  if (r.core.estimator.heading_valid()) health |= S::kYawPosition;
  if (r.core.estimator.height_valid()) health |= S::kZAltitudeControl;
  if (r.core.estimator.position_valid()) health |= S::kXyPositionControl;
  if (ready_to_arm(r.core, r.now)) health |= S::kPrearmCheck;
  m.load = 0;  // not measured
  m.voltage_battery = 0xFFFF;
  m.current_battery = -1;
  m.battery_remaining = -1;
  if (const auto battery = r.core.battery.reading(r.core.commander.armed())) {
    health |= S::kBattery;
    m.voltage_battery = millivolts(battery->voltage_v);
    m.current_battery = centi(battery->current_a);
    m.battery_remaining = percent(battery->remaining);
  }
  m.onboard_control_sensors_health = health;
  r.send(m);
}

MavVtolState vtol_state(const Commander& commander) {
  if (commander.airframe() != AirframeKind::kVtol) return MavVtolState::kUndefined;
  switch (commander.vtol_state()) {
    case VtolState::kMulticopter:
      return MavVtolState::kMc;
    case VtolState::kToPlane:
      return MavVtolState::kTransitionToFw;
    case VtolState::kPlane:
      return MavVtolState::kFw;
    case VtolState::kToMulticopter:
      return MavVtolState::kTransitionToMc;
  }
  return MavVtolState::kUndefined;
}

void send_extended_sys_state(const Report& r) {
  ExtendedSysState m;
  m.vtol_state = vtol_state(r.core.commander);
  switch (r.core.commander.landed()) {
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
  r.send(m);
}

void send_battery_status(const Report& r) {
  constexpr std::uint16_t kNoCell = 0xFFFF;
  BatteryStatus m;
  m.battery_function = MavBatteryFunction::kAll;
  m.type = MavBatteryType::kLipo;
  m.temperature = 0x7FFF;
  m.voltages.fill(kNoCell);
  m.current_battery = -1;
  m.current_consumed = -1;
  m.energy_consumed = -1;
  m.battery_remaining = -1;
  const auto battery = r.core.battery.reading(r.core.commander.armed());
  if (!battery) return r.send(m);
  for (int i = 0; i < std::min(battery->cells, 10); ++i) {
    m.voltages[static_cast<std::size_t>(i)] = millivolts(battery->voltage_v / battery->cells);
  }
  m.current_battery = centi(battery->current_a);
  m.current_consumed = static_cast<std::int32_t>(battery->consumed_mah);
  m.battery_remaining = percent(battery->remaining);
  const double left = battery->remaining;
  m.charge_state = left < r.core.flight.battery_emergency  ? MavBatteryChargeState::kEmergency
                   : left < r.core.flight.battery_critical ? MavBatteryChargeState::kCritical
                   : left < r.core.flight.battery_low      ? MavBatteryChargeState::kLow
                                                           : MavBatteryChargeState::kOk;
  r.send(m);
}

void send_estimator_status(const Report& r) {
  using E = EstimatorStatusFlags;
  const Estimator& e = r.core.estimator;
  EstimatorStatus m;
  m.time_usec = r.core.time_boot_us(r.now);
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
  r.send(m);
}

void send_vibration(const Report& r) {
  const Vector3d v = r.core.readings.vibration.square.cwiseMax(0.0).cwiseSqrt();
  r.send(Vibration{r.core.time_boot_us(r.now), to_float(v.x()), to_float(v.y()), to_float(v.z()), 0,
                   0, 0});
}

void send_gps_raw(const Report& r) {
  if (!r.core.readings.gps) return;
  const HilGps& g = *r.core.readings.gps;
  GpsRawInt m;
  m.time_usec = r.core.time_boot_us(r.now);
  m.fix_type = r.core.readings.health.alive(SensorHealth::kGps, r.now)
                   ? static_cast<GpsFixType>(g.fix_type)
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
  const EstimatorParams& noise = r.core.estimator.params();
  m.h_acc = static_cast<std::uint32_t>(1000 * noise.gps_position_noise_m);
  m.v_acc = static_cast<std::uint32_t>(1000 * noise.gps_height_noise_m);
  m.vel_acc = static_cast<std::uint32_t>(1000 * noise.gps_velocity_noise_m_s);
  r.send(m);
}

void send_scaled_pressure(const Report& r) {
  ScaledPressure m;
  m.time_boot_ms = r.core.time_boot_ms(r.now);
  m.press_abs = to_float(r.core.readings.pressure_hpa);
  m.temperature = centi(r.core.readings.temperature_degc);
  r.send(m);
}

void send_servo_output_raw(const Report& r) {
  const Mixer& mixer = r.core.cascade.mixer();
  auto outputs = mixer.outputs(r.core.cascade.output());
  const auto pwm = [&](std::size_t i) -> std::uint16_t {
    OutputKind kind = mixer.output_kind(i);
    if (kind == OutputKind::kNothing && r.core.wing) {
      kind = r.core.wing->output_kind(i);
      outputs[i] = r.core.wing->outputs()[i];
    }
    if (kind == OutputKind::kNothing) return 0;
    if (kind == OutputKind::kServo) {
      return static_cast<std::uint16_t>(1500 + std::lround(500 * outputs[i]));
    }
    return static_cast<std::uint16_t>(
        r.core.commander.armed() ? 1000 + std::lround(1000 * outputs[i]) : 900);
  };
  ServoOutputRaw m;
  m.time_usec = static_cast<std::uint32_t>(r.core.time_boot_us(r.now));
  std::uint16_t* const fields[] = {&m.servo1_raw,  &m.servo2_raw,  &m.servo3_raw,  &m.servo4_raw,
                                   &m.servo5_raw,  &m.servo6_raw,  &m.servo7_raw,  &m.servo8_raw,
                                   &m.servo9_raw,  &m.servo10_raw, &m.servo11_raw, &m.servo12_raw,
                                   &m.servo13_raw, &m.servo14_raw, &m.servo15_raw, &m.servo16_raw};
  for (std::size_t i = 0; i < std::size(fields); ++i) *fields[i] = pwm(i);
  r.send(m);
}

void send_system_time(const Report& r) { r.send(SystemTime{0, r.core.time_boot_ms(r.now)}); }

void send_mission_current(const Report& r) {
  const MissionTask& mission = r.core.commander.mission();
  const bool flown = r.core.commander.mode() == FlightMode::kMission;
  MissionCurrent m;
  m.seq = static_cast<std::uint16_t>(mission.current());
  m.total = static_cast<std::uint16_t>(mission.items().size());
  m.mission_state = mission.items().empty() ? MissionState::kNoMission
                    : mission.finished()    ? MissionState::kComplete
                    : flown                 ? MissionState::kActive
                                            : MissionState::kNotStarted;
  m.mission_mode = flown ? 1 : 2;
  r.send(m);
}

// Version and modes.

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

void send_autopilot_version(const Report& r) {
  using C = MavProtocolCapability;
  AutopilotVersion m;
  m.capabilities = C::kMissionInt | C::kParamFloat | C::kCommandInt | C::kParamEncodeBytewise |
                   C::kSetAttitudeTarget | C::kSetPositionTargetLocalNed |
                   C::kSetPositionTargetGlobalInt | C::kFlightTermination | C::kMavlink2 | C::kFtp;
  // major, minor, patch, FIRMWARE_VERSION_TYPE_OFFICIAL: a release that ground stations know the
  // modes and parameters of.
  m.flight_sw_version = 1U << 24U | 15U << 16U | 0U << 8U | 255U;
  m.uid = r.core.config.system_id;
  r.send(m);
}

void send_protocol_version(const Report& r) {
  ProtocolVersion m;
  m.version = 200;
  m.min_version = 100;
  m.max_version = 200;
  r.send(m);
}

void send_available_modes(const Report& r) {
  for (std::size_t i = 0; i < kModes.size(); ++i) {
    AvailableModes m;
    m.number_modes = static_cast<std::uint8_t>(kModes.size());
    m.mode_index = static_cast<std::uint8_t>(i + 1);
    m.standard_mode = kModes[i].standard;
    m.custom_mode = px4_custom_mode(kModes[i].mode);
    mav::set_text(m.mode_name, kModes[i].title);
    r.send(m);
  }
}

void send_current_mode(const Report& r) {
  CurrentMode m;
  for (const ModeInfo& info : kModes) {
    if (info.mode == r.core.commander.mode()) m.standard_mode = info.standard;
  }
  m.custom_mode = px4_custom_mode(r.core.commander.mode());
  m.intended_custom_mode = m.custom_mode;
  r.send(m);
}

constexpr MessageSource kSources[] = {
    {Heartbeat::kId, 1, send_heartbeat},
    {SysStatus::kId, 1, send_sys_status},
    {Attitude::kId, 50, send_attitude},
    {AttitudeQuaternion::kId, 10, send_attitude_quaternion},
    {AttitudeTarget::kId, 2, send_attitude_target},
    {LocalPositionNed::kId, 30, send_local_position},
    {PositionTargetLocalNed::kId, 10, send_position_target},
    {GlobalPositionInt::kId, 5, send_global_position},
    {GpsRawInt::kId, 2, send_gps_raw},
    {VfrHud::kId, 4, send_vfr_hud},
    {mavlink::common::Altitude::kId, 1, send_altitude},
    {Vibration::kId, 0.5, send_vibration},
    {EstimatorStatus::kId, 1, send_estimator_status},
    {ExtendedSysState::kId, 1, send_extended_sys_state},
    {BatteryStatus::kId, 0.5, send_battery_status},
    {HomePosition::kId, 0.5, send_home_position},
    {GpsGlobalOrigin::kId, 0, send_gps_global_origin},
    {ServoOutputRaw::kId, 2, send_servo_output_raw},
    {ScaledPressure::kId, 0, send_scaled_pressure},
    {SystemTime::kId, 1, send_system_time},
    {MissionCurrent::kId, 1, send_mission_current},
    {AutopilotVersion::kId, 0, send_autopilot_version},
    {ProtocolVersion::kId, 0, send_protocol_version},
    {AvailableModes::kId, 0, send_available_modes},
    {CurrentMode::kId, 0.5, send_current_mode},
};

}  // namespace

std::span<const MessageSource> message_sources() { return kSources; }

}  // namespace cas::fcu
