// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet/own_numbers.hpp"

#include "mavlink_gen/runtime/crc.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

/// Whether casd made the packet and may change its sequence number: a signature would break.
bool may_be_numbered(const PacketRef& packet) {
  return OwnNumbers::is_own(packet) && !mav::view_packet(packet.bytes).is_signed();
}

void put_number(std::span<std::uint8_t> packet, std::uint8_t number, std::uint8_t crc_extra) {
  const bool is_v2 = packet[0] == mav::kStartV2;
  const std::size_t end = (is_v2 ? mav::kHeaderBytesV2 : mav::kHeaderBytesV1) + packet[1];
  packet[is_v2 ? 4 : 2] = number;
  const std::uint16_t crc =
      mav::Crc16().update(packet.subspan(1, end - 1)).update(crc_extra).value();
  packet[end] = static_cast<std::uint8_t>(crc);
  packet[end + 1] = static_cast<std::uint8_t>(crc >> 8U);
}

}  // namespace

std::span<const PacketRef> OwnNumbers::renumber(std::span<const PacketRef> packets) {
  packets_.assign(packets.begin(), packets.end());
  if (bytes_.size() < packets.size()) bytes_.resize(packets.size());
  const std::vector<Next> before = next_;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    if (!may_be_numbered(packets[i])) continue;
    const mav::MessageInfo* message = mav::public_table().find(packets[i].info->message_id);
    if (message == nullptr) continue;
    const std::span copy(bytes_[i].data(), packets[i].bytes.size());
    std::ranges::copy(packets[i].bytes, copy.begin());
    put_number(copy, next_of(packets[i].info->source)++, message->crc_extra);
    packets_[i].bytes = copy;
  }
  next_ = before;  // sent() advances it
  return packets_;
}

void OwnNumbers::sent(std::span<const PacketRef> packets) {
  for (const PacketRef& packet : packets) {
    if (may_be_numbered(packet)) ++next_of(packet.info->source);
  }
}

std::uint8_t& OwnNumbers::next_of(mav::Source source) {
  const auto known = std::ranges::find(next_, source, &Next::source);
  return known != next_.end() ? known->number : next_.emplace_back(Next{source, 0}).number;
}

}  // namespace cas::casd
