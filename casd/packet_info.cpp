// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet_info.hpp"

namespace cas::casd {
namespace {

std::uint8_t byte_at(std::span<const std::uint8_t> payload, int offset) {
  if (offset < 0 || static_cast<std::size_t>(offset) >= payload.size()) return 0;
  return payload[static_cast<std::size_t>(offset)];
}

}  // namespace

PacketInfo inspect(const mav::PacketView& packet, const mav::MessageTable& table) {
  PacketInfo info;
  info.message_id = packet.message_id;
  info.source = packet.source;
  info.traffic = classify(packet.message_id);
  if (const mav::MessageInfo* known = table.find(packet.message_id)) {
    info.target.system = byte_at(packet.payload, known->target_system_offset);
    info.target.component = byte_at(packet.payload, known->target_component_offset);
  }
  return info;
}

}  // namespace cas::casd
