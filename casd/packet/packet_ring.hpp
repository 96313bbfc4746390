// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "casd/packet/packet_info.hpp"

namespace cas::casd {

/// A waiting packet with its properties.
struct QueuedPacket {
  PacketInfo info;
  std::span<const std::uint8_t> bytes;
};

/// First in, first out; packets lie end to end in one block of memory that is allocated once, at
/// the first push.
class PacketRing {
 public:
  /// @param capacity_bytes  of the block: packets and 64 bytes of bookkeeping each
  explicit PacketRing(std::size_t capacity_bytes) : capacity_(capacity_bytes) {}

  /// @return false when there is no room
  bool push(const PacketInfo& info, std::span<const std::uint8_t> bytes);
  /// The oldest packet. Its bytes hold until the next push.
  QueuedPacket front() const;
  void pop();
  void clear();

  bool empty() const { return count_ == 0; }
  std::size_t count() const { return count_; }

 private:
  struct Record {
    PacketInfo info;
    std::uint32_t size = 0;
  };
  static std::size_t stride(std::size_t size);

  std::size_t capacity_;
  std::vector<std::uint8_t> block_;
  std::size_t head_ = 0;  ///< oldest record
  std::size_t tail_ = 0;  ///< where the next one goes
  std::size_t end_ = 0;   ///< where the records before a wrap end
  std::size_t count_ = 0;
};

}  // namespace cas::casd
