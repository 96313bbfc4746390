// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "casd/packet/packet_info.hpp"
#include "casd/packet/packet_ring.hpp"
#include "casd/words/drop_cause.hpp"

namespace cas::casd {

/// Waiting setpoints, only the newest of each stream. It takes the place of the older one, so
/// streams take turns at any rates.
class NewestSetpoints {
 public:
  /// More are invented senders; they displace only setpoints that came over the same way.
  static constexpr std::size_t kMaxWaiting = 128;
  using OnDrop = std::function<void(const PacketInfo&, DropCause)>;

  /// Copies the packet in; it replaces the older ones of its stream.
  void push(const PacketInfo& info, std::span<const std::uint8_t> bytes, const OnDrop& on_drop);
  /// The packet whose turn it is, taken out; its bytes hold until the next call.
  QueuedPacket pop();
  /// Drops those for which too_late(PacketInfo, size) holds.
  template <class TooLate>
  void drop_late(TooLate&& too_late, const OnDrop& on_drop) {
    std::erase_if(waiting_, [&](const Waiting& each) {
      if (!too_late(each.info, each.bytes.size())) return false;
      if (on_drop) on_drop(each.info, DropCause::kAge);
      return true;
    });
  }

  bool empty() const { return waiting_.empty(); }
  std::size_t count() const { return waiting_.size(); }

 private:
  struct Waiting {
    PacketInfo info;
    std::vector<std::uint8_t> bytes;
  };
  void make_room(const PacketInfo& info, const OnDrop& on_drop);

  std::vector<Waiting> waiting_;
  Waiting popped_;
};

}  // namespace cas::casd
