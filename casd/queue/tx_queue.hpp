// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include "base/time/clock.hpp"
#include "casd/packet/packet_info.hpp"
#include "casd/packet/packet_ring.hpp"
#include "casd/queue/line_timing.hpp"

namespace cas::casd {

/// Why a packet did not go out.
enum class DropCause : std::uint8_t {
  kAge,         ///< would have arrived too late to be worth anything
  kBandwidth,   ///< too late as well, because of the cap that the topology sets
  kQueueFull,   ///< its class, or the socket, had no room left
  kClosed,      ///< the link was away, or came back and what waited was stale
  kStalled,     ///< the peer stopped reading and was closed
  kUnsignable,  ///< its checksum fits no message, so that it cannot be signed
};
inline constexpr int kDropCauses = 6;
std::string_view to_string(DropCause cause);

struct TxQueueOptions {
  base::Duration hil_max_age = std::chrono::milliseconds(25);
  base::Duration gps_max_age = std::chrono::milliseconds(400);
  base::Duration telemetry_max_age = std::chrono::seconds(1);
  std::size_t command_bytes = 256 * 1024;
  std::size_t hil_bytes = 1024 * 1024;
  std::size_t gps_bytes = 32 * 1024;
  std::size_t telemetry_bytes = 256 * 1024;

  friend bool operator==(const TxQueueOptions&, const TxQueueOptions&) = default;
};

/// Packets that wait for a link, by class, each class with memory of its own.
///
///   command    FIFO; a new one is refused only when the class is full; never dropped once in
///   hil        FIFO; dropped only when it could no longer arrive within its age limit (or, as the
///              last resort, the oldest for lack of memory)
///   gps        the same with a longer limit
///   telemetry  goes when nothing else waits; old ones make room for new ones
///
/// Command, hil and gps share the line by bytes, 4 : 8 : 2 while all of them wait (fair queueing by
/// virtual time): none starves another, and who has waited little goes first.
class TxQueue {
 public:
  using OnDrop = std::function<void(const PacketInfo&, DropCause)>;

  explicit TxQueue(const TxQueueOptions& options = {}, OnDrop on_drop = {});

  /// Copies the packet in. @return false when it was refused (and counted)
  bool push(const PacketInfo& info, std::span<const std::uint8_t> bytes);
  /// The packet whose turn it is, taken out; its bytes hold until the next push. Packets that would
  /// arrive too late over `line` are dropped on the way.
  std::optional<QueuedPacket> pop(base::RunTime now, const LinePacer& line);
  /// Drops everything: the link went away.
  void clear(DropCause cause);

  /// Would a packet that is handed to `line` now arrive too late?
  bool too_late(const PacketInfo& info, std::size_t size, base::RunTime now,
                const LinePacer& line) const;

  bool empty() const { return count() == 0; }
  std::size_t count() const;
  std::size_t high_water() const { return high_water_; }  ///< most packets that ever waited

 private:
  void drop_late(base::RunTime now, const LinePacer& line);
  std::optional<TrafficClass> next_class() const;
  void drop_front(TrafficClass traffic, DropCause cause);
  PacketRing& ring(TrafficClass traffic) { return rings_[static_cast<std::size_t>(traffic)]; }
  const PacketRing& ring(TrafficClass traffic) const {
    return rings_[static_cast<std::size_t>(traffic)];
  }

  TxQueueOptions options_;
  OnDrop on_drop_;
  std::array<PacketRing, kTrafficClasses> rings_;
  std::array<double, kTrafficClasses> virtual_time_{};
  double virtual_now_ = 0;
  std::size_t high_water_ = 0;
};

}  // namespace cas::casd
