// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "base/time/clock.hpp"
#include "casd/packet/link_id.hpp"
#include "casd/packet/link_mask.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Finds packets that somebody sends back over another link: a ground station that forwards what it
/// receives to a second port of casd makes a loop, in which each packet goes round for ever.
///
/// A packet that comes over one link again and again, though another link has brought it once and
/// not again, goes round. So many turns prove a loop; from then on the link's packets that others
/// brought before are copies, until none has come for kCalm. A packet that two links have brought
/// twice proves nothing: its sender repeats itself, and one of its links may have died.
///
/// The guard keeps a mark of each link's last packets, by sender and sequence number. `on_packet`
/// for one link belongs to one thread at a time; different links may run on different threads.
class LoopGuard {
 public:
  enum class Verdict : std::uint8_t {
    kFine,
    kFound,  ///< goes round, and is the first that proves it
    kCopy    ///< came over another link, and back
  };
  /// Turns that prove a loop. A recording that is played over one link and then over another comes
  /// again, too, but neither so often nor so soon.
  static constexpr unsigned kEnough = 6;
  static constexpr base::Duration kSoon = std::chrono::milliseconds(400);
  static constexpr base::Duration kMemory = std::chrono::seconds(3);
  static constexpr base::Duration kCalm = std::chrono::seconds(10);

  Verdict on_packet(LinkId from, const mav::PacketView& packet, base::RunTime now) {
    Link& own = links_[from];
    Table* table = own.table.load(std::memory_order_relaxed);
    if (table == nullptr) [[unlikely]]
      table = make_table(own);
    Cell& cell = (*table)[place_of(packet)];
    const Mark mark = mark_of(packet, now);
    const Mark before{cell.load(std::memory_order_relaxed)};
    cell.store(mark.value, std::memory_order_relaxed);
    if (!own.loops && !before.is_same(mark)) [[likely]]
      return Verdict::kFine;
    return judge(from, place_of(packet), mark, before, now);
  }

 private:
  /// From the top: 32 bits of content, a note of 4, 28 of time in units of 2^20 ns; 0: none. A note
  /// below kEnough counts turns; kEnough tells that the sender repeats itself.
  struct Mark {
    std::uint64_t value = 0;

    static constexpr unsigned kTimeBits = 28;
    unsigned note() const { return static_cast<unsigned>(value >> kTimeBits) & 0xFU; }
    Mark with_note(unsigned note) const { return {value | std::uint64_t{note} << kTimeBits}; }
    bool repeats() const { return note() == kEnough; }
    bool is_same(Mark other) const { return (value ^ other.value) >> 32U == 0; }
    /// Units from the other mark to this one; many where the other one is later.
    std::uint32_t since(Mark other) const {
      return static_cast<std::uint32_t>(value - other.value) & ((1U << kTimeBits) - 1);
    }
  };
  using Cell = std::atomic<std::uint64_t>;  ///< of a mark; one thread writes it
  using Table = std::array<Cell, 1024>;
  struct alignas(64) Link {
    std::atomic<Table*> table{nullptr};
    bool loops = false;
    base::RunTime calm_at{};
    std::unique_ptr<Table> owned;
  };

  static constexpr std::uint32_t units(base::Duration time) {
    return static_cast<std::uint32_t>(time.count() >> 20U);
  }
  /// 256 places for the sequence numbers of a sender.
  static std::size_t place_of(const mav::PacketView& packet) {
    const unsigned sender = packet.source.system * 31U + packet.source.component;
    return (sender % 4 << 8U | packet.sequence) & 1023U;
  }
  static Mark mark_of(const mav::PacketView& packet, base::RunTime now) {
    const std::uint8_t* const crc = packet.payload.data() + packet.payload.size();
    const std::uint32_t checksum = crc[0] | std::uint32_t{crc[1]} << 8U;
    const std::uint32_t sender =
        std::uint32_t{packet.source.system} << 8U | packet.source.component;
    const std::uint32_t rest = (sender ^ packet.message_id * 0x9E5U) % 0x10000U;
    constexpr std::uint32_t kTime = (1U << Mark::kTimeBits) - 1;
    return {std::uint64_t{checksum << 16U | rest} << 32U | (units(now.time_since_epoch()) & kTime)};
  }

  static Table* make_table(Link& link);
  Verdict judge(LinkId from, std::size_t place, Mark mark, Mark before, base::RunTime now);
  enum class Needs : std::uint8_t { kAny, kOnceBefore };
  /// Whether another link brought the packet within kMemory; kOnceBefore: no later than this mark,
  /// and once.
  bool came_elsewhere(LinkId from, std::size_t place, Mark mark, Needs needs) const;

  std::array<Link, kLinkSlots> links_;
};

}  // namespace cas::casd
