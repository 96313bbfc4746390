// SPDX-License-Identifier: BSD-3-Clause
#include "casd/counters/message_counters.hpp"

#include <algorithm>

namespace cas::casd {

void MessageCounters::add(std::uint32_t message_id, mav::Source source, base::RunTime now) {
  constexpr std::uint64_t kUsed = std::uint64_t{1} << 63U;
  const std::uint64_t key = kUsed | std::uint64_t{message_id} << 16U |
                            std::uint64_t{source.system} << 8U | source.component;
  Slot* slot = find(key, now);
  if (slot == nullptr) {
    uncounted_.store(uncounted_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    return;
  }
  slot->count.store(slot->count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  slot->last_ns.store(now.time_since_epoch().count(), std::memory_order_relaxed);
}

MessageCounters::Slot* MessageCounters::find(std::uint64_t key, base::RunTime now) {
  Slot* slots = slots_.load(std::memory_order_relaxed);
  if (slots == nullptr) {
    slots = new Slot[kSlots];
    slots_.store(slots, std::memory_order_release);
  }
  constexpr std::uint64_t kMultiplier = 0x9E3779B97F4A7C15ULL;  // spreads neighbouring keys
  std::size_t at = (key * kMultiplier) >> 53U;                  // 11 bits: kSlots
  static_assert(kSlots == std::size_t{1} << 11U);
  Slot* quietest = nullptr;
  for (std::size_t i = 0; i < kProbes; ++i, at = (at + 1) % kSlots) {
    Slot& slot = slots[at];
    const std::uint64_t found = slot.key.load(std::memory_order_relaxed);
    if (found == key) return &slot;
    if (found == 0) {
      begin(slot, key, now);
      return &slot;
    }
    const auto heard = [](const Slot& each) {
      return each.last_ns.load(std::memory_order_relaxed);
    };
    if (quietest == nullptr || heard(slot) < heard(*quietest)) quietest = &slot;
  }
  const base::RunTime last{base::Duration(quietest->last_ns.load(std::memory_order_relaxed))};
  if (now - last <= kFresh) return nullptr;
  begin(*quietest, key, now);
  return quietest;
}

/// While the key is 0 a reader skips the slot: it never takes the count of one kind for another's.
void MessageCounters::begin(Slot& slot, std::uint64_t key, base::RunTime now) {
  const std::int64_t now_ns = now.time_since_epoch().count();
  slot.key.store(0, std::memory_order_relaxed);
  slot.count.store(0, std::memory_order_release);
  slot.since_ns.store(now_ns, std::memory_order_release);
  slot.last_ns.store(now_ns, std::memory_order_release);
  slot.key.store(key, std::memory_order_release);
}

std::optional<MessageCounters::Entry> MessageCounters::read(const Slot& slot) {
  const std::uint64_t key = slot.key.load(std::memory_order_acquire);
  if (key == 0) return std::nullopt;
  const auto time = [](const std::atomic<std::int64_t>& ns) {
    return base::RunTime{base::Duration(ns.load(std::memory_order_acquire))};
  };
  const Entry entry{static_cast<std::uint32_t>((key >> 16U) & 0xFFFFFFU),
                    {static_cast<std::uint8_t>(key >> 8U), static_cast<std::uint8_t>(key)},
                    slot.count.load(std::memory_order_acquire),
                    time(slot.since_ns),
                    time(slot.last_ns)};
  if (slot.key.load(std::memory_order_relaxed) != key) return std::nullopt;
  return entry;
}

std::vector<MessageCounters::Entry> MessageCounters::kinds(base::RunTime now) const {
  std::vector<Entry> all;
  for_each([&all](const Entry& entry) { all.push_back(entry); });
  if (all.size() <= kRestingKinds) return all;
  const auto silent = std::partition(
      all.begin(), all.end(), [now](const Entry& entry) { return now - entry.last <= kFresh; });
  const auto fresh = silent - all.begin();
  const auto room = std::max<std::ptrdiff_t>(std::ptrdiff_t{kRestingKinds} - fresh, 0);
  if (room >= all.end() - silent) return all;
  std::nth_element(silent, silent + room, all.end(),
                   [](const Entry& a, const Entry& b) { return a.last > b.last; });
  all.erase(silent + room, all.end());
  return all;
}

}  // namespace cas::casd
