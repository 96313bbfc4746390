// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"

namespace cas::sim {

/// Servo packet of ArduPilot's SITL to a JSON simulator, which answers with the motion.
struct ServoPacket {
  static constexpr std::size_t kMostChannels = 32;

  std::uint16_t frame_rate_hz = 0;  ///< packets per second that it asks for
  std::uint32_t frame_count = 0;    ///< from 0 at its start; repeated when no answer came
  std::array<std::uint16_t, kMostChannels> pwm_us{};
};

/// Little-endian: u16 magic, u16 frame rate, u32 frame count, u16 pulse widths: 16 with magic 18458
/// (40 bytes), 32 with magic 29569 (72 bytes). @return nullopt when it is neither
std::optional<ServoPacket> parse_servo_packet(std::span<const std::uint8_t> bytes);

/// Outputs 1..16 from channels 1..16: a rotor's is (pwm - 1000) / 1000, held to 0..1, a servo's
/// (pwm - 1500) / 500, held to -1..1; a control surface without a pulse stays at 0. All rotors at
/// or below 1000 us is disarmed: armed ones idle above that.
MotorCommand to_motor_command(const ServoPacket& packet, const base::Vehicle& vehicle);

/// The true motion of a vehicle on ArduPilot's terms: forward-right-down and north-east-down, SI.
struct JsonState {
  double timestamp_s = 0;
  Eigen::Vector3d gyro_D = Eigen::Vector3d::Zero();   ///< rad/s
  Eigen::Vector3d accel_D = Eigen::Vector3d::Zero();  ///< specific force, m/s^2
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();      ///< from home, m
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();      ///< m/s
  Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();
  std::optional<double> range_m;       ///< of a rangefinder, when there is one
  std::optional<double> airspeed_m_s;  ///< true airspeed by a pitot tube, when there is one
};

/// True airspeed of a pitot tube's pressure, which ArduPilot 4.6 turns into a pressure again by its
/// own standard atmosphere; below zero for air from behind.
double to_airspeed_m_s(double differential_pressure_pa, double air_density_kg_m3);

JsonState to_json_state(base::SimTime time, const BodyState& body, const Environment& air);

/// One line as ArduPilot's parser wants it. That is no JSON parser: it searches for keys as
/// substrings, so no further key may contain one of them, and takes '[' only directly behind the
/// colon. The line begins and ends with '\n'.
std::string to_text(const JsonState& state);

}  // namespace cas::sim
