// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/ardupilot_json/servo_packet.hpp"

#include <algorithm>

namespace cas::sim {
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

MotorCommand to_motor_command(const ServoPacket& packet) {
  MotorCommand command;
  command.kind = MotorCommand::Kind::kMotorOutputs;
  for (int i = 0; i < base::kRotors; ++i) {
    const double pwm_us = packet.pwm_us[static_cast<std::size_t>(i)];
    command.values[i] = std::clamp((pwm_us - kStopped_us) / kRange_us, 0.0, 1.0);
    command.armed = command.armed || pwm_us > kStopped_us;
  }
  return command;
}

}  // namespace cas::sim
