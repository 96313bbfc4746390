// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "libsim/api/messages.hpp"

namespace cas::sim {

/// What ArduPilot's SITL sends to a JSON simulator to be answered with the motion.
struct ServoPacket {
  static constexpr std::size_t kMostChannels = 32;

  std::uint16_t frame_rate_hz = 0;  ///< packets per second that it asks for
  std::uint32_t frame_count = 0;    ///< from 0 at its start; repeated when no answer came
  std::array<std::uint16_t, kMostChannels> pwm_us{};
};

/// Little-endian: u16 magic, u16 frame rate, u32 frame count, u16 pulse widths: 16 with magic 18458
/// (40 bytes), 32 with magic 29569 (72 bytes). @return nothing when it is neither
std::optional<ServoPacket> parse_servo_packet(std::span<const std::uint8_t> bytes);

/// Outputs of rotors 1..4 from channels 1..4: (pwm - 1000) / 1000, held to 0..1. All at or below
/// 1000 us is disarmed: armed rotors idle above that.
MotorCommand to_motor_command(const ServoPacket& packet);

}  // namespace cas::sim
