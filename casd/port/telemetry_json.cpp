// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/telemetry_json.hpp"

#include <fmt/format.h>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>

#include "base/earth/deg_e7.hpp"
#include "casd/port/call_json.hpp"
#include "casd/port/vehicle_json.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using nlohmann::json;

/// Whole milliseconds say enough of an age.
double rounded_s(base::Duration age) { return std::round(base::to_seconds(age) * 1e3) / 1e3; }

/// The message of a topic, or an empty one whose values are not looked at.
template <class M>
struct Source {
  explicit Source(const std::optional<Heard<M>>& heard)
      : came(heard.has_value()),
        message(heard ? heard->message : M{}),
        at(heard ? heard->at : mav::services::Time{}) {}

  /// The value, or null where the message has not come or says that it does not know.
  json value(double number, bool known = true) const {
    return came && known ? number_json(number) : json();
  }
  json degrees(float radians) const {
    return value(static_cast<float>(radians * 180 / std::numbers::pi));
  }
  json flag(bool is_set) const { return came ? json(is_set) : json(); }
  json age_s(base::RunTime now) const { return came ? json(rounded_s(now - at)) : json(); }

  bool came;
  M message;
  base::RunTime at;
};

template <class Number>
bool is_told(Number value) {
  return value != std::numeric_limits<Number>::max();
}

json state(const VehicleState& vehicle, base::RunTime now) {
  return json{{"armed", vehicle.armed()},
              {"mode", vehicle.mode()},
              {"landed", vehicle.landed_word()},
              {"system_state", state_word(vehicle.heartbeat().message.system_status)},
              {"age_s", rounded_s(vehicle.heartbeat_age(now))}};
}

json attitude(const Source<Attitude>& from, base::RunTime now) {
  return json{{"roll_deg", from.degrees(from.message.roll)},
              {"pitch_deg", from.degrees(from.message.pitch)},
              {"yaw_deg", from.degrees(from.message.yaw)},
              {"age_s", from.age_s(now)}};
}

json rates(const Source<Attitude>& from, base::RunTime now) {
  return json{{"roll_deg_s", from.degrees(from.message.rollspeed)},
              {"pitch_deg_s", from.degrees(from.message.pitchspeed)},
              {"yaw_deg_s", from.degrees(from.message.yawspeed)},
              {"age_s", from.age_s(now)}};
}

json position(const Source<LocalPositionNed>& from, base::RunTime now) {
  return json{{"north_m", from.value(from.message.x)},
              {"east_m", from.value(from.message.y)},
              {"down_m", from.value(from.message.z)},
              {"age_s", from.age_s(now)}};
}

json velocity(const Source<LocalPositionNed>& from, base::RunTime now) {
  return json{{"north_m_s", from.value(from.message.vx)},
              {"east_m_s", from.value(from.message.vy)},
              {"down_m_s", from.value(from.message.vz)},
              {"age_s", from.age_s(now)}};
}

json global(const Source<GlobalPositionInt>& from, base::RunTime now) {
  const GlobalPositionInt& here = from.message;
  return json{{"lat_deg", from.value(base::degrees_of_e7(here.lat))},
              {"lon_deg", from.value(base::degrees_of_e7(here.lon))},
              {"alt_m", from.value(here.alt / 1e3)},
              {"relative_alt_m", from.value(here.relative_alt / 1e3)},
              {"heading_deg", from.value(here.hdg / 1e2, is_told(here.hdg))},
              {"age_s", from.age_s(now)}};
}

json global(const Source<HighLatency2>& from, const std::optional<HomeAmsl>& home,
            base::RunTime now) {
  constexpr double kHeadingUnit_deg = 2;
  const HighLatency2& here = from.message;
  return json{
      {"lat_deg", from.value(base::degrees_of_e7(here.latitude))},
      {"lon_deg", from.value(base::degrees_of_e7(here.longitude))},
      {"alt_m", from.value(here.altitude)},
      {"relative_alt_m", from.value(here.altitude - home.value_or(HomeAmsl{}).alt_m, !!home)},
      {"heading_deg", from.value(here.heading * kHeadingUnit_deg)},
      {"age_s", from.age_s(now)}};
}

json global(const VehicleState& vehicle, base::RunTime now) {
  if (vehicle.is_high_latency()) {
    return global(Source<HighLatency2>(vehicle.high_latency()), vehicle.home(), now);
  }
  return global(Source<GlobalPositionInt>(vehicle.global_position()), now);
}

json sys_status_battery(const Source<SysStatus>& from, base::RunTime now) {
  const SysStatus& status = from.message;
  return json{
      {"voltage_v", from.value(status.voltage_battery / 1e3, is_told(status.voltage_battery))},
      {"current_a", from.value(status.current_battery / 1e2, status.current_battery != -1)},
      {"remaining_percent", from.value(status.battery_remaining, status.battery_remaining != -1)},
      {"age_s", from.age_s(now)}};
}

/// Sum of the cells that are measured; nullopt where none is.
std::optional<double> pack_voltage_v(const BatteryStatus& status) {
  int sum_mv = 0;
  bool any = false;
  for (const std::uint16_t cell_mv : status.voltages) {
    if (!is_told(cell_mv)) continue;
    sum_mv += cell_mv;
    any = true;
  }
  if (!any) return std::nullopt;
  return std::accumulate(status.voltages_ext.begin(), status.voltages_ext.end(), sum_mv) / 1e3;
}

json battery_status_battery(const Source<BatteryStatus>& from, base::RunTime now) {
  const BatteryStatus& status = from.message;
  const std::optional<double> voltage_v = pack_voltage_v(status);
  return json{
      {"voltage_v", from.value(voltage_v.value_or(0), voltage_v.has_value())},
      {"current_a", from.value(status.current_battery / 1e2, status.current_battery != -1)},
      {"remaining_percent", from.value(status.battery_remaining, status.battery_remaining != -1)},
      {"age_s", from.age_s(now)}};
}

/// From SYS_STATUS, which comes more often; from BATTERY_STATUS if that has no battery.
json battery(const VehicleState& vehicle, base::RunTime now) {
  if (vehicle.is_high_latency()) {
    const Source<HighLatency2> from(vehicle.high_latency());
    return json{{"voltage_v", nullptr},
                {"current_a", nullptr},
                {"remaining_percent", from.value(from.message.battery, from.message.battery >= 0)},
                {"age_s", from.age_s(now)}};
  }
  const Source<SysStatus> often(vehicle.sys_status());
  const bool told = often.came && is_told(often.message.voltage_battery);
  if (told || !vehicle.battery_status()) return sys_status_battery(often, now);
  return battery_status_battery(Source<BatteryStatus>(vehicle.battery_status()), now);
}

std::string fix_word(GpsFixType fix) {
  constexpr const char* kWords[] = {"no_gps",    "no_fix",    "2d",     "3d", "dgps",
                                    "rtk_float", "rtk_fixed", "static", "ppp"};
  const auto index = static_cast<std::size_t>(fix);
  return index < std::size(kWords) ? kWords[index] : fmt::format("fix {}", index);
}

json gps(const Source<GpsRawInt>& from, base::RunTime now) {
  const GpsRawInt& raw = from.message;
  const bool fixed = raw.fix_type >= GpsFixType::k2dFix;
  const auto accuracy = [&from](std::uint32_t mm) { return from.value(mm / 1e3, mm != 0); };
  return json{{"fix", from.came ? json(fix_word(raw.fix_type)) : json()},
              {"satellites", from.value(raw.satellites_visible, is_told(raw.satellites_visible))},
              {"lat_deg", from.value(base::degrees_of_e7(raw.lat), fixed)},
              {"lon_deg", from.value(base::degrees_of_e7(raw.lon), fixed)},
              {"alt_m", from.value(raw.alt / 1e3, fixed)},
              {"hdop", from.value(raw.eph / 1e2, is_told(raw.eph))},
              {"vdop", from.value(raw.epv / 1e2, is_told(raw.epv))},
              {"speed_m_s", from.value(raw.vel / 1e2, is_told(raw.vel))},
              {"course_deg", from.value(raw.cog / 1e2, is_told(raw.cog))},
              {"horizontal_accuracy_m", accuracy(raw.h_acc)},
              {"vertical_accuracy_m", accuracy(raw.v_acc)},
              {"age_s", from.age_s(now)}};
}

json estimator(const Source<EstimatorStatus>& from, base::RunTime now) {
  using enum EstimatorStatusFlags;
  const EstimatorStatus& status = from.message;
  const auto flag = [&](EstimatorStatusFlags bit) { return from.flag(has(status.flags, bit)); };
  return json{{"attitude_ok", flag(kAttitude)},
              {"horizontal_velocity_ok", flag(kVelocityHoriz)},
              {"vertical_velocity_ok", flag(kVelocityVert)},
              {"horizontal_position_ok", flag(kPosHorizAbs)},
              {"height_ok", flag(kPosVertAbs)},
              {"gps_glitch", flag(kGpsGlitch)},
              {"accel_error", flag(kAccelError)},
              {"velocity_ratio", from.value(status.vel_ratio)},
              {"horizontal_position_ratio", from.value(status.pos_horiz_ratio)},
              {"height_ratio", from.value(status.pos_vert_ratio)},
              {"mag_ratio", from.value(status.mag_ratio)},
              {"horizontal_accuracy_m", from.value(status.pos_horiz_accuracy)},
              {"vertical_accuracy_m", from.value(status.pos_vert_accuracy)},
              {"age_s", from.age_s(now)}};
}

json rotors(const Source<ServoOutputRaw>& from, base::RunTime now) {
  const ServoOutputRaw& raw = from.message;
  const std::uint16_t pulses_us[] = {raw.servo1_raw, raw.servo2_raw, raw.servo3_raw,
                                     raw.servo4_raw, raw.servo5_raw, raw.servo6_raw,
                                     raw.servo7_raw, raw.servo8_raw};
  json outputs{{"age_s", from.age_s(now)}};
  for (std::size_t i = 0; i < std::size(pulses_us); ++i) {
    outputs[fmt::format("output{}_us", i + 1)] = from.value(pulses_us[i], pulses_us[i] != 0);
  }
  return outputs;
}

}  // namespace

json telemetry_json(const VehicleState& vehicle, base::RunTime now) {
  const Source<Attitude> turn(vehicle.attitude());
  const Source<LocalPositionNed> local(vehicle.local_position());
  return json{{"vehicle", vehicle.source().system},
              {"state", state(vehicle, now)},
              {"attitude", attitude(turn, now)},
              {"rates", rates(turn, now)},
              {"position", position(local, now)},
              {"velocity", velocity(local, now)},
              {"global", global(vehicle, now)},
              {"battery", battery(vehicle, now)},
              {"gps", gps(Source<GpsRawInt>(vehicle.gps_raw()), now)},
              {"estimator", estimator(Source<EstimatorStatus>(vehicle.estimator_status()), now)},
              {"rotors", rotors(Source<ServoOutputRaw>(vehicle.servo_output()), now)}};
}

}  // namespace cas::casd
