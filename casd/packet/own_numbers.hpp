// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "casd/packet/packet_port.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Sequence numbers of casd's own packets towards one destination. Receivers count a gap as a loss
/// of their link, so what goes to others leaves none here. Packets of others stay as they are, and
/// so do signed ones.
class OwnNumbers {
 public:
  /// @return the packets, casd's own with the numbers that come next; good until the next call
  std::span<const PacketRef> number(std::span<const PacketRef> packets) {
    if (std::ranges::none_of(packets, is_own)) return packets;
    return renumber(packets);
  }
  /// Counts these packets' numbers as used: they have left, or are lost on their way.
  void sent(std::span<const PacketRef> packets);

  static bool is_own(const PacketRef& packet) { return packet.info->from == kLocalLink; }

 private:
  struct Next {
    mav::Source source;
    std::uint8_t number = 0;
  };

  std::span<const PacketRef> renumber(std::span<const PacketRef> packets);
  std::uint8_t& next_of(mav::Source source);

  std::vector<Next> next_;  ///< by sender: casd's station and its failure injector
  std::vector<std::array<std::uint8_t, mav::kMaxPacketBytes>> bytes_;
  std::vector<PacketRef> packets_;
};

}  // namespace cas::casd
