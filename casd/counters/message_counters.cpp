// SPDX-License-Identifier: BSD-3-Clause
#include "casd/counters/message_counters.hpp"

namespace cas::casd {

void MessageCounters::add(std::uint32_t message_id, mav::Source source, base::RunTime now) {
  constexpr std::uint64_t kUsed = std::uint64_t{1} << 63U;
  const std::uint64_t key = kUsed | std::uint64_t{message_id} << 16U |
                            std::uint64_t{source.system} << 8U | source.component;
  Slot* slot = find(key);
  if (slot == nullptr) {
    uncounted_.store(uncounted_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    return;
  }
  slot->count.store(slot->count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  slot->last_ns.store(now.time_since_epoch().count(), std::memory_order_relaxed);
}

MessageCounters::Slot* MessageCounters::find(std::uint64_t key) {
  Slot* slots = slots_.load(std::memory_order_relaxed);
  if (slots == nullptr) {
    slots = new Slot[kSlots];
    slots_.store(slots, std::memory_order_release);
  }
  constexpr std::uint64_t kMultiplier = 0x9E3779B97F4A7C15ULL;  // spreads neighbouring keys
  std::size_t at = (key * kMultiplier) >> 53U;                  // 11 bits: kSlots
  static_assert(kSlots == std::size_t{1} << 11U);
  for (std::size_t i = 0; i < kProbes; ++i, at = (at + 1) % kSlots) {
    const std::uint64_t found = slots[at].key.load(std::memory_order_relaxed);
    if (found == key) return &slots[at];
    if (found == 0) {
      slots[at].key.store(key, std::memory_order_release);
      return &slots[at];
    }
  }
  return nullptr;
}

}  // namespace cas::casd
