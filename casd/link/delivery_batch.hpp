// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "casd/packet/link_id.hpp"
#include "casd/packet/packet_port.hpp"

namespace cas::casd {

/// The ports of all links, by slot: an immutable snapshot.
using PortTable = std::array<std::shared_ptr<PacketPort>, kMaxLinks>;

/// Packets that one read brought, sorted by destination, so that each destination gets them in one
/// call. Bytes lie end to end, so a run of packets to one link is one write.
class DeliveryBatch {
 public:
  DeliveryBatch();

  /// True when the next packet might not fit: deliver first.
  bool full() const { return infos_.size() == kMaxPackets; }
  bool empty() const { return infos_.empty(); }
  void add(const PacketInfo& info, std::span<const std::uint8_t> bytes, LinkMask to);
  /// Hands everything over and starts anew.
  void deliver(const PortTable& ports, base::RunTime now);

 private:
  static constexpr std::size_t kMaxPackets = 256;

  std::vector<PacketInfo> infos_;
  std::vector<std::uint8_t> bytes_;
  std::array<std::vector<PacketRef>, kMaxLinks> by_link_;
  LinkMask touched_ = 0;
};

}  // namespace cas::casd
