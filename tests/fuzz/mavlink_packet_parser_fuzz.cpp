// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a stream: whole, bytewise and in pieces the same packets come out, each with the
// right checksum, in order and apart from each other.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace {

using namespace cas::mav;
using Packets = std::vector<std::vector<std::uint8_t>>;

Packets receive(std::span<const std::uint8_t> bytes, std::size_t piece) {
  Packets packets;
  PacketParser parser(mavlink::common::table());
  const auto keep = [&](const PacketView& view) {
    packets.emplace_back(view.bytes.begin(), view.bytes.end());
  };
  for (std::size_t i = 0; i < bytes.size(); i += piece) {
    const auto size = piece < bytes.size() - i ? piece : bytes.size() - i;
    parser.feed(bytes.subspan(i, size), keep);
  }
  parser.flush(keep);
  const auto& stats = parser.stats();
  std::uint64_t accounted = stats.skipped_bytes;
  for (const auto& packet : packets) accounted += packet.size();
  if (accounted != bytes.size()) std::abort();  // each byte is in a packet or skipped
  return packets;
}

/// The checksum bit by bit: independent of the tables.
bool has_right_checksum(const std::vector<std::uint8_t>& packet) {
  const auto view = view_packet(packet);
  const auto* info = mavlink::common::table().find(view.message_id);
  if (info == nullptr) return false;
  unsigned crc = 0xFFFF;
  const auto add = [&](std::uint8_t byte) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0x8408U : crc >> 1U;
  };
  const auto* end = view.payload.data() + view.payload.size();
  for (const auto* p = packet.data() + 1; p != end; ++p) add(*p);
  add(info->crc_extra);
  return end[0] == (crc & 0xFFU) && end[1] == crc >> 8U;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  if (bytes.empty()) return 0;
  const auto whole = receive(bytes, bytes.size());
  if (receive(bytes, 1) != whole || receive(bytes, 13) != whole) std::abort();
  for (const auto& packet : whole) {
    if (!has_right_checksum(packet)) std::abort();
  }
  return 0;
}
