// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mavlink_gen/runtime/packet.hpp"

namespace cas::mav {

/// Counts the gaps in the sequence numbers of each system and component.
///
/// A jump of up to half the number range forward is a loss; a larger one means a repeated or late
/// packet, or that the sender began anew, and counts nothing. Sources beyond the 64th are not
/// judged.
class SequenceTracker {
 public:
  /// Sources that are followed; losses of further ones are not counted.
  static constexpr std::size_t kMaxSources = 64;

  /// @return packets lost just before this one
  unsigned update(Source source, std::uint8_t sequence) {
    ++received_;
    auto* entry = find_or_add(source, sequence);
    if (entry == nullptr) return 0;
    constexpr unsigned kHalfRange = 128;
    const auto gap = static_cast<std::uint8_t>(sequence - entry->next);
    entry->next = static_cast<std::uint8_t>(sequence + 1);
    if (gap >= kHalfRange) return 0;
    lost_ += gap;
    return gap;
  }

  /// Packets lost so far, of all sources.
  std::uint64_t lost() const { return lost_; }
  /// Packets received so far, of all sources.
  std::uint64_t received() const { return received_; }

 private:
  struct Entry {
    Source source;
    std::uint8_t next{};
  };

  Entry* find_or_add(Source source, std::uint8_t sequence) {
    for (std::size_t i = 0; i < size_; ++i) {
      if (entries_[i].source == source) return &entries_[i];
    }
    if (size_ == kMaxSources) return nullptr;
    entries_[size_] = {source, sequence};
    return &entries_[size_++];
  }

  std::array<Entry, kMaxSources> entries_{};
  std::size_t size_{};
  std::uint64_t lost_{};
  std::uint64_t received_{};
};

}  // namespace cas::mav
