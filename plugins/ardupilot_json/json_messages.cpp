// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/ardupilot_json/json_messages.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "base/earth/frames.hpp"

namespace cas::sim {

// From the firmware.

namespace {

constexpr std::uint16_t kMagic16 = 18458;
constexpr std::uint16_t kMagic32 = 29569;
constexpr std::size_t kHeaderBytes = 8;
constexpr double kStopped_us = 1000;
constexpr double kRange_us = 1000;

std::uint16_t u16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8U);
}

std::uint32_t u32(std::span<const std::uint8_t> bytes, std::size_t at) {
  return u16(bytes, at) | static_cast<std::uint32_t>(u16(bytes, at + 2)) << 16U;
}

}  // namespace

std::optional<ServoPacket> parse_servo_packet(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kHeaderBytes) return std::nullopt;
  const std::uint16_t magic = u16(bytes, 0);
  const std::size_t channels = magic == kMagic16 ? 16 : magic == kMagic32 ? 32 : 0;
  if (channels == 0 || bytes.size() != kHeaderBytes + 2 * channels) return std::nullopt;
  ServoPacket packet;
  packet.frame_rate_hz = u16(bytes, 2);
  packet.frame_count = u32(bytes, 4);
  for (std::size_t i = 0; i < channels; ++i) packet.pwm_us[i] = u16(bytes, kHeaderBytes + 2 * i);
  return packet;
}

MotorCommand to_motor_command(const ServoPacket& packet, const base::Vehicle& vehicle) {
  MotorCommand command;
  command.kind = MotorCommand::Kind::kMotorOutputs;
  command.values.setZero(base::kMaxOutputs);
  const auto share = [&packet](int output) {  // of the pulse's range
    const double pwm_us = packet.pwm_us[static_cast<std::size_t>(output)];
    return std::clamp((pwm_us - kStopped_us) / kRange_us, 0.0, 1.0);
  };
  for (const base::Rotor& rotor : vehicle.rotors) {
    command.values[rotor.output] = share(rotor.output);
    command.armed = command.armed || command.values[rotor.output] > 0;
    if (rotor.tilt) command.values[rotor.tilt->output] = 2 * share(rotor.tilt->output) - 1;
  }
  if (!vehicle.aero) return command;
  for (const base::ControlSurface& surface : vehicle.aero->surfaces) {
    const bool has_pulse = packet.pwm_us[static_cast<std::size_t>(surface.output)] > 0;
    if (has_pulse) command.values[surface.output] = 2 * share(surface.output) - 1;
  }
  return command;
}

// To the firmware.

namespace {

/// ArduPilot would read a non-finite number as garbage; a sane simulation sends none.
double finite(double value) { return std::isfinite(value) ? value : 0.0; }

void append(std::string& text, double value) {
  char number[48];
  std::snprintf(number, sizeof number, "%.9f", finite(value));
  text += number;
}

void append(std::string& text, const char* key, std::span<const double> values) {
  text += key;
  char before = '[';
  for (const double value : values) {
    text += before;
    append(text, value);
    before = ',';
  }
  text += ']';
}

void append(std::string& text, const char* key, const Eigen::Vector3d& values) {
  append(text, key, std::span(values.data(), 3));
}

}  // namespace

double to_airspeed_m_s(double differential_pressure_pa, double air_density_kg_m3) {
  const double speed = std::sqrt(2 * std::abs(differential_pressure_pa) / air_density_kg_m3);
  return std::copysign(speed, differential_pressure_pa);
}

JsonState to_json_state(base::SimTime time, const BodyState& body, const Environment& air) {
  const Eigen::Matrix3d R_BW = body.q_WB.conjugate().toRotationMatrix();
  JsonState state;
  state.timestamp_s = base::to_seconds(time);
  state.gyro_D = base::swap_BD(body.w_WB_B);
  state.accel_D = base::swap_BD(R_BW * (body.a_WB - air.gravity_W));
  state.p_N = base::swap_WN(body.p_WB);
  state.v_N = base::swap_WN(body.v_WB);
  state.q_ND = base::q_ND_from_q_WB(body.q_WB);
  return state;
}

std::string to_text(const JsonState& state) {
  const Eigen::Quaterniond& q = state.q_ND;
  const double quaternion[] = {q.w(), q.x(), q.y(), q.z()};
  std::string text = "\n{\"timestamp\":";
  append(text, state.timestamp_s);
  append(text, ",\"imu\":{\"gyro\":", state.gyro_D);
  append(text, ",\"accel_body\":", state.accel_D);
  append(text, "},\"position\":", state.p_N);
  append(text, ",\"velocity\":", state.v_N);
  append(text, ",\"quaternion\":", quaternion);
  if (state.range_m) {
    text += ",\"rng_1\":";
    append(text, *state.range_m);
  }
  if (state.airspeed_m_s) {
    text += ",\"airspeed\":";
    append(text, *state.airspeed_m_s);
  }
  return text + "}\n";
}

}  // namespace cas::sim
