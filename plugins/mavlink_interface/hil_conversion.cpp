// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/hil_conversion.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "base/angles.hpp"
#include "base/earth/atmosphere.hpp"
#include "base/earth/deg_e7.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"
#include "mavlink_gen/services/station_heartbeat.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;

constexpr unsigned kModeArmed = 128;          // MAV_MODE_FLAG_SAFETY_ARMED
constexpr std::uint16_t kUnknown16 = 0xFFFF;  // "unknown" of HIL_GPS
constexpr std::uint8_t kNoFix = 1;            // GPS_FIX_TYPE_NO_FIX
constexpr std::uint8_t kFix2d = 2;            // GPS_FIX_TYPE_2D_FIX
constexpr double kPascalPerHectopascal = 100.0;

float to_float(double value) { return static_cast<float>(value); }

/// Rounds and keeps within the wire type; 0 for NaN.
template <class Integer>
Integer to_wire(double value) {
  if (std::isnan(value)) return 0;
  constexpr double kLow = std::numeric_limits<Integer>::min();
  constexpr double kHigh = std::numeric_limits<Integer>::max();
  return static_cast<Integer>(std::clamp(std::round(value), kLow, kHigh));
}

/// As to_wire, but NaN, and only NaN, becomes kUnknown16.
std::uint16_t to_known16(double value) {
  if (std::isnan(value)) return kUnknown16;
  return std::min<std::uint16_t>(to_wire<std::uint16_t>(value), kUnknown16 - 1);
}

void flag(mv::HilSensor& packet, std::uint32_t bits) {
  using Flags = std::remove_cvref_t<decltype(packet.fields_updated)>;
  packet.fields_updated =
      static_cast<Flags>(static_cast<std::uint32_t>(packet.fields_updated) | bits);
}

/// Course over ground in 0..35999 centidegrees.
std::uint16_t course(const Eigen::Vector3d& velocity_N) {
  const double degrees = base::degrees(std::atan2(velocity_N.y(), velocity_N.x()));
  const long centidegrees = std::lround(degrees * 100.0);
  return static_cast<std::uint16_t>((centidegrees + 36000) % 36000);
}

/// A receiver with such a solution has none.
bool is_solution(const GpsSample& sample) {
  return sample.velocity_N.allFinite() && std::isfinite(sample.position.lat_deg) &&
         std::isfinite(sample.position.lon_deg) && std::isfinite(sample.position.alt_m);
}

double within(float value, double low, double high) {
  return std::isfinite(value) ? std::clamp<double>(value, low, high) : 0.0;
}

template <class Mode>
bool is_armed(Mode mode) {
  return (static_cast<unsigned>(mode) & kModeArmed) != 0;
}

/// MAV_SENSOR_ORIENTATION of a beam: one of MAVLink's where it is no farther from it than files
/// round, else a quaternion that turns Dx into the beam.
void set_direction(mv::DistanceSensor& packet, const Eigen::Vector3d& direction_B) {
  using R = mv::MavSensorOrientation;
  constexpr double kSame = 1e-3;  // rad
  constexpr double kHalf = 0.70710678118654752;
  struct Named {
    Eigen::Vector3d direction_D;
    R orientation;
  };
  static const std::array<Named, 10> kNamed{{{{0, 0, 1}, R::kRotationPitch270},
                                             {{0, 0, -1}, R::kRotationPitch90},
                                             {{1, 0, 0}, R::kRotationNone},
                                             {{kHalf, kHalf, 0}, R::kRotationYaw45},
                                             {{0, 1, 0}, R::kRotationYaw90},
                                             {{-kHalf, kHalf, 0}, R::kRotationYaw135},
                                             {{-1, 0, 0}, R::kRotationYaw180},
                                             {{-kHalf, -kHalf, 0}, R::kRotationYaw225},
                                             {{0, -1, 0}, R::kRotationYaw270},
                                             {{kHalf, -kHalf, 0}, R::kRotationYaw315}}};
  const Eigen::Vector3d direction_D(direction_B.x(), -direction_B.y(), -direction_B.z());
  for (const Named& named : kNamed) {
    if ((named.direction_D - direction_D).norm() > kSame) continue;
    packet.orientation = named.orientation;
    return;
  }
  packet.orientation = R::kRotationCustom;
  const auto q = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), direction_D);
  packet.quaternion = {static_cast<float>(q.w()), static_cast<float>(q.x()),
                       static_cast<float>(q.y()), static_cast<float>(q.z())};
}

}  // namespace

void fill(mv::HilSensor& packet, const ImuSample& sample) {
  const Eigen::Vector3d f_D = base::swap_BD(sample.specific_force_B);
  const Eigen::Vector3d w_D = base::swap_BD(sample.angular_rate_B);
  packet.time_usec = base::to_time_usec(sample.time);
  packet.xacc = to_float(f_D.x());
  packet.yacc = to_float(f_D.y());
  packet.zacc = to_float(f_D.z());
  packet.xgyro = to_float(w_D.x());
  packet.ygyro = to_float(w_D.y());
  packet.zgyro = to_float(w_D.z());
  flag(packet, kUpdatedAccel | kUpdatedGyro);
}

void fill(mv::HilSensor& packet, const MagnetometerSample& sample) {
  const Eigen::Vector3d field_D = base::swap_BD(sample.field_B_gauss);
  packet.xmag = to_float(field_D.x());
  packet.ymag = to_float(field_D.y());
  packet.zmag = to_float(field_D.z());
  flag(packet, kUpdatedMag);
}

void fill(mv::HilSensor& packet, const BarometerSample& sample) {
  packet.abs_pressure = to_float(sample.pressure_pa / kPascalPerHectopascal);
  packet.pressure_alt = to_float(base::isa::altitude_m(sample.pressure_pa));
  packet.temperature = to_float(sample.temperature_degc);
  flag(packet, kUpdatedBaro);
}

void fill(mv::HilSensor& packet, const AirspeedSample& sample) {
  packet.diff_pressure = to_float(sample.differential_pressure_pa / kPascalPerHectopascal);
  flag(packet, kUpdatedDiffPressure);
}

mv::HilGps to_hil_gps(const GpsSample& sample) {
  mv::HilGps packet;
  packet.time_usec = base::to_time_usec(sample.time);
  const bool has_fix = sample.fix_type >= kFix2d && is_solution(sample);
  packet.fix_type = static_cast<decltype(packet.fix_type)>(
      has_fix ? sample.fix_type : std::min(sample.fix_type, kNoFix));
  packet.satellites_visible = sample.satellites;
  packet.eph = to_known16(sample.eph_m * 100.0);
  packet.epv = to_known16(sample.epv_m * 100.0);
  packet.vel = packet.cog = kUnknown16;
  if (!has_fix) return packet;
  packet.lat = to_wire<std::int32_t>(sample.position.lat_deg * base::kDegE7);
  packet.lon = to_wire<std::int32_t>(sample.position.lon_deg * base::kDegE7);
  packet.alt = to_wire<std::int32_t>(sample.position.alt_m * 1e3);
  packet.vn = to_wire<std::int16_t>(sample.velocity_N.x() * 100.0);
  packet.ve = to_wire<std::int16_t>(sample.velocity_N.y() * 100.0);
  packet.vd = to_wire<std::int16_t>(sample.velocity_N.z() * 100.0);
  packet.vel = to_known16(sample.velocity_N.head<2>().norm() * 100.0);
  packet.cog = course(sample.velocity_N);
  return packet;
}

mv::DistanceSensor to_distance_sensor(const RangeSample& sample) {
  constexpr std::uint8_t kInvalidSignal = 1;
  constexpr std::uint8_t kFullSignal = 100;
  constexpr std::uint8_t kUnknownCovariance = 255;
  mv::DistanceSensor packet;
  packet.time_boot_ms = static_cast<std::uint32_t>(base::to_time_usec(sample.time) / 1000);
  packet.min_distance = to_known16(sample.min_m * 100.0);
  packet.max_distance = to_known16(sample.max_m * 100.0);
  packet.current_distance = to_known16(sample.distance_m * 100.0);
  // A cone is that of a sonar.
  packet.type =
      sample.beam_rad > 0 ? mv::MavDistanceSensor::kUltrasound : mv::MavDistanceSensor::kLaser;
  packet.horizontal_fov = packet.vertical_fov = static_cast<float>(sample.beam_rad);
  set_direction(packet, sample.direction_B);
  packet.covariance = kUnknownCovariance;
  // Centimetres in 16 bits end at 655 m.
  const bool fits = sample.distance_m >= 0 && sample.distance_m * 100.0 < kUnknown16;
  packet.signal_quality = sample.valid && fits ? kFullSignal : kInvalidSignal;
  return packet;
}

mv::BatteryStatus to_battery_status(const BatterySample& sample) {
  constexpr std::uint16_t kNoCell = 0xFFFF;
  constexpr double kMostOfField = kNoCell - 1;  // mV; the rest goes into the next field
  mv::BatteryStatus packet;
  packet.battery_function = mv::MavBatteryFunction::kAll;
  packet.temperature = std::numeric_limits<std::int16_t>::max();  // unknown
  packet.voltages.fill(kNoCell);
  double left_mv = sample.voltage_v * 1000.0;
  for (std::uint16_t& field : packet.voltages) {
    field = to_wire<std::uint16_t>(std::min(left_mv, kMostOfField));
    left_mv -= kMostOfField;
    if (!(left_mv > 0)) break;
  }
  packet.set_current_battery_a(sample.current_a);
  packet.set_current_consumed_ah(sample.used_ah);
  packet.energy_consumed = -1;  // unknown
  packet.battery_remaining = to_wire<std::int8_t>(sample.charge * 100.0);
  return packet;
}

mv::EscStatus to_esc_status(const EscSample& sample, int first) {
  constexpr double kRpmPerRad_s = 30 / M_PI;
  mv::EscStatus packet;
  packet.index = static_cast<std::uint8_t>(first);
  packet.time_usec = base::to_time_usec(sample.time);
  const int last =
      std::min<int>(first + kEscsInAMessage, static_cast<int>(sample.omega_rad_s.size()));
  for (int i = first; i < last; ++i) {
    const auto at = static_cast<std::size_t>(i - first);
    packet.rpm[at] = to_wire<std::int32_t>(sample.omega_rad_s[i] * kRpmPerRad_s);
    packet.voltage[at] = static_cast<float>(sample.voltage_v);
    packet.current[at] = static_cast<float>(sample.current_a[i]);
  }
  return packet;
}

mv::EscInfo to_esc_info(const EscSample& sample, int first, std::uint16_t counter) {
  constexpr std::uint8_t kDshot = 5;  // ESC_CONNECTION_TYPE: the one that brings telemetry back
  mv::EscInfo packet;
  packet.index = static_cast<std::uint8_t>(first);
  packet.time_usec = base::to_time_usec(sample.time);
  packet.counter = counter;
  packet.count = static_cast<std::uint8_t>(sample.omega_rad_s.size());
  packet.connection_type = kDshot;
  packet.temperature.fill(std::numeric_limits<std::int16_t>::max());  // unknown
  for (int i = 0; i < std::min<int>(kEscsInAMessage, packet.count - first); ++i) {
    packet.info = static_cast<std::uint8_t>(packet.info | 1U << i);
  }
  return packet;
}

mv::HilStateQuaternion to_hil_state(base::SimTime time, const BodyState& body,
                                    const Environment& air,
                                    const base::LocalProjection& projection) {
  mv::HilStateQuaternion packet;
  packet.time_usec = base::to_time_usec(time);
  Eigen::Quaterniond q_ND = base::q_ND_from_q_WB(body.q_WB);
  if (q_ND.w() < 0) q_ND.coeffs() *= -1;  // the same attitude; level to the north is (1, 0, 0, 0)
  packet.attitude_quaternion = {to_float(q_ND.w()), to_float(q_ND.x()), to_float(q_ND.y()),
                                to_float(q_ND.z())};
  const Eigen::Vector3d w_D = base::swap_BD(body.w_WB_B);
  packet.rollspeed = to_float(w_D.x());
  packet.pitchspeed = to_float(w_D.y());
  packet.yawspeed = to_float(w_D.z());
  const base::Geodetic place = projection.to_geodetic(base::swap_WN(body.p_WB));
  packet.lat = to_wire<std::int32_t>(place.lat_deg * base::kDegE7);
  packet.lon = to_wire<std::int32_t>(place.lon_deg * base::kDegE7);
  packet.alt = to_wire<std::int32_t>(place.alt_m * 1e3);
  const Eigen::Vector3d v_N = base::swap_WN(body.v_WB);
  packet.vx = to_wire<std::int16_t>(v_N.x() * 100.0);
  packet.vy = to_wire<std::int16_t>(v_N.y() * 100.0);
  packet.vz = to_wire<std::int16_t>(v_N.z() * 100.0);
  const double airspeed = (body.v_WB - air.wind_W).norm();
  const double indicated =
      airspeed * std::sqrt(air.air_density_kg_m3 / base::isa::density_kg_m3(0));
  packet.ind_airspeed = to_wire<std::uint16_t>(indicated * 100.0);
  packet.true_airspeed = to_wire<std::uint16_t>(airspeed * 100.0);
  const Eigen::Vector3d a_D = base::swap_BD(body.q_WB.conjugate() * body.a_WB);
  packet.xacc = to_wire<std::int16_t>(a_D.x() / base::kStandardGravity_m_s2 * 1e3);
  packet.yacc = to_wire<std::int16_t>(a_D.y() / base::kStandardGravity_m_s2 * 1e3);
  packet.zacc = to_wire<std::int16_t>(a_D.z() / base::kStandardGravity_m_s2 * 1e3);
  return packet;
}

mv::Heartbeat simulator_heartbeat() {
  return mav::services::station_heartbeat(mv::MavType::kGeneric);
}

MotorCommand to_motor_command(const mv::HilControls& packet, const base::ControlScales& scales) {
  MotorCommand command;
  command.sensor_time = base::from_time_usec(packet.time_usec);
  command.kind = MotorCommand::Kind::kControlInputs;
  command.armed = is_armed(packet.mode);
  command.values = Eigen::Vector4d(within(packet.throttle, 0, 1) * scales.u1_max_n,
                                   within(packet.roll_ailerons, -1, 1) * scales.u2_max_nm,
                                   within(packet.pitch_elevator, -1, 1) * scales.u3_max_nm,
                                   within(packet.yaw_rudder, -1, 1) * scales.u4_max_nm);
  return command;
}

MotorCommand to_motor_command(const mv::HilActuatorControls& packet) {
  MotorCommand command;
  command.sensor_time = base::from_time_usec(packet.time_usec);
  command.kind = MotorCommand::Kind::kMotorOutputs;
  command.armed = is_armed(packet.mode);
  command.values.resize(base::kMaxOutputs);
  for (int i = 0; i < base::kMaxOutputs; ++i) {
    command.values[i] = within(packet.controls[static_cast<std::size_t>(i)], -1, 1);
  }
  return command;
}

}  // namespace cas::sim
