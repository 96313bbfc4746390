// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/time/clock.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Counts packets by message, system and component: an open hash table of fixed size. One writer at
/// a time, any number of readers, no lock; memory is taken at the first packet. A kind that has
/// been silent for kFresh gives its place to a new one where there is no other.
class MessageCounters {
 public:
  /// A kind that was heard so recently is always kept.
  static constexpr base::Duration kFresh = std::chrono::seconds(30);
  /// Where there are more kinds than this, silent ones fill what the fresh leave of it, last heard
  /// first.
  static constexpr std::size_t kRestingKinds = 512;

  struct Entry {
    std::uint32_t message_id = 0;
    mav::Source source;
    std::uint64_t count = 0;
    base::RunTime since;  ///< the first one
    base::RunTime last;
  };

  MessageCounters() = default;
  ~MessageCounters() { delete[] slots_.load(std::memory_order_acquire); }
  MessageCounters(const MessageCounters&) = delete;
  MessageCounters& operator=(const MessageCounters&) = delete;

  void add(std::uint32_t message_id, mav::Source source, base::RunTime now);
  /// Packets that found the table full: more kinds than any real network has.
  std::uint64_t uncounted() const { return uncounted_.load(std::memory_order_relaxed); }

  /// Calls visit(const Entry&) for each kind in the table.
  template <class Visit>
  void for_each(Visit&& visit) const {
    const Slot* slots = slots_.load(std::memory_order_acquire);
    if (slots == nullptr) return;
    for (std::size_t i = 0; i < kSlots; ++i) {
      if (const std::optional<Entry> entry = read(slots[i])) visit(*entry);
    }
  }
  /// The kinds worth a look: after a flood of invented senders the table seems to shrink again.
  std::vector<Entry> kinds(base::RunTime now) const;

 private:
  static constexpr std::size_t kSlots = 2048;
  static constexpr std::size_t kProbes = 64;
  struct Slot {
    std::atomic<std::uint64_t> key{0};  ///< used bit, message, system, component
    std::atomic<std::uint64_t> count{0};
    std::atomic<std::int64_t> since_ns{0};
    std::atomic<std::int64_t> last_ns{0};
  };
  static std::optional<Entry> read(const Slot& slot);
  static void begin(Slot& slot, std::uint64_t key, base::RunTime now);
  Slot* find(std::uint64_t key, base::RunTime now);

  std::atomic<Slot*> slots_{nullptr};
  std::atomic<std::uint64_t> uncounted_{0};
};

}  // namespace cas::casd
