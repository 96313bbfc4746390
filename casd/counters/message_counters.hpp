// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "base/time/clock.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Counts packets by message, system and component: an open hash table of fixed size. One writer at
/// a time, any number of readers, no lock; memory is taken at the first packet.
class MessageCounters {
 public:
  struct Entry {
    std::uint32_t message_id = 0;
    mav::Source source;
    std::uint64_t count = 0;
    base::RunTime last;
  };

  MessageCounters() = default;
  ~MessageCounters() { delete[] slots_.load(std::memory_order_acquire); }
  MessageCounters(const MessageCounters&) = delete;
  MessageCounters& operator=(const MessageCounters&) = delete;

  void add(std::uint32_t message_id, mav::Source source, base::RunTime now);
  /// Packets that found the table full: more kinds than any real network has.
  std::uint64_t uncounted() const { return uncounted_.load(std::memory_order_relaxed); }

  /// Calls visit(const Entry&) for each kind that was ever seen.
  template <class Visit>
  void for_each(Visit&& visit) const {
    const Slot* slots = slots_.load(std::memory_order_acquire);
    if (slots == nullptr) return;
    for (std::size_t i = 0; i < kSlots; ++i) {
      const std::uint64_t key = slots[i].key.load(std::memory_order_acquire);
      if (key == 0) continue;
      const base::RunTime last{base::Duration(slots[i].last_ns.load(std::memory_order_relaxed))};
      visit(Entry{static_cast<std::uint32_t>((key >> 16U) & 0xFFFFFFU),
                  {static_cast<std::uint8_t>(key >> 8U), static_cast<std::uint8_t>(key)},
                  slots[i].count.load(std::memory_order_relaxed),
                  last});
    }
  }

 private:
  static constexpr std::size_t kSlots = 2048;
  static constexpr std::size_t kProbes = 64;
  struct Slot {
    std::atomic<std::uint64_t> key{0};  ///< used bit, message, system, component
    std::atomic<std::uint64_t> count{0};
    std::atomic<std::int64_t> last_ns{0};
  };
  Slot* find(std::uint64_t key);

  std::atomic<Slot*> slots_{nullptr};
  std::atomic<std::uint64_t> uncounted_{0};
};

}  // namespace cas::casd
