// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet_info.hpp"

#include <span>

namespace cas::casd {
namespace {

bool is_stamped_hil(std::uint32_t message_id) {
  constexpr std::uint32_t kHilControls = 91, kHilActuatorControls = 93, kHilSensor = 107,
                          kHilGps = 113;
  return message_id == kHilSensor || message_id == kHilControls || message_id == kHilGps ||
         message_id == kHilActuatorControls;
}

// time_usec leads the payload, little-endian; zeros at the end may be cut off.
std::uint64_t leading_u64(std::span<const std::uint8_t> payload) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof value && i < payload.size(); ++i) {
    value |= static_cast<std::uint64_t>(payload[i]) << (8 * i);
  }
  return value;
}

}  // namespace

PacketInfo inspect(const mav::PacketView& packet, const mav::MessageTable& table) {
  PacketInfo info;
  info.message_id = packet.message_id;
  info.source = packet.source;
  info.traffic = classify(packet.message_id);
  if (is_stamped_hil(packet.message_id)) info.hil_time_usec = leading_u64(packet.payload);
  if (const mav::MessageInfo* known = table.find(packet.message_id)) {
    info.target = mav::target_of(packet, *known);
  }
  return info;
}

}  // namespace cas::casd
