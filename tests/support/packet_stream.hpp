// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::test {

/// The packets in a peer's received bytes, kept whole.
class PacketStream {
 public:
  struct Packet {
    std::uint32_t message_id = 0;
    mav::Source source;
    std::uint8_t sequence = 0;
    std::vector<std::uint8_t> bytes;

    mav::PacketView view() const { return mav::view_packet(bytes); }
  };

  void feed(std::span<const std::uint8_t> bytes) {
    parser_.feed(bytes, [this](const mav::PacketView& packet) {
      packets_.push_back({packet.message_id,
                          packet.source,
                          packet.sequence,
                          {packet.bytes.begin(), packet.bytes.end()}});
    });
  }
  std::deque<Packet>& packets() { return packets_; }
  std::size_t count(std::uint32_t message_id) const {
    std::size_t n = 0;
    for (const Packet& packet : packets_) n += packet.message_id == message_id ? 1 : 0;
    return n;
  }
  /// Bytes that were part of no packet, and packets with a wrong checksum.
  std::uint64_t garbage() const { return parser_.stats().skipped_bytes; }

 private:
  mav::PacketParser parser_{mav::public_table()};
  std::deque<Packet> packets_;
};

}  // namespace cas::test
