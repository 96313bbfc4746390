// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet/packet_ring.hpp"

#include <cstring>
#include <type_traits>

namespace cas::casd {

std::size_t PacketRing::stride(std::size_t size) {
  static_assert(std::is_trivially_copyable_v<Record>);
  constexpr std::size_t kAlign = 8;
  return (sizeof(Record) + size + kAlign - 1) / kAlign * kAlign;
}

bool PacketRing::push(const PacketInfo& info, std::span<const std::uint8_t> bytes) {
  if (block_.empty()) block_.resize(capacity_);
  if (count_ == 0) head_ = tail_ = end_ = 0;
  const std::size_t need = stride(bytes.size());

  // Behind the tail up to the block's end or the head; else wrap to the front, if that is free.
  const bool wrapped = count_ > 0 && tail_ <= head_;
  if (wrapped) {
    if (tail_ + need > head_) return false;
  } else if (tail_ + need > capacity_) {
    if (need > head_) return false;
    end_ = tail_;
    tail_ = 0;
  }
  const Record record{info, static_cast<std::uint32_t>(bytes.size())};
  std::memcpy(block_.data() + tail_, &record, sizeof record);
  std::memcpy(block_.data() + tail_ + sizeof record, bytes.data(), bytes.size());
  tail_ += need;
  if (tail_ > head_) end_ = tail_;
  ++count_;
  return true;
}

QueuedPacket PacketRing::front() const {
  Record record;
  std::memcpy(&record, block_.data() + head_, sizeof record);
  return {record.info, {block_.data() + head_ + sizeof record, record.size}};
}

void PacketRing::pop() {
  Record record;
  std::memcpy(&record, block_.data() + head_, sizeof record);
  head_ += stride(record.size);
  --count_;
  if (count_ > 0 && head_ == end_) {
    head_ = 0;
    end_ = tail_;
  }
}

void PacketRing::clear() {
  head_ = tail_ = end_ = 0;
  count_ = 0;
}

}  // namespace cas::casd
