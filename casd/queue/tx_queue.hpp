// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "base/time/clock.hpp"
#include "casd/packet/packet_info.hpp"
#include "casd/packet/packet_ring.hpp"
#include "casd/queue/line_timing.hpp"
#include "casd/queue/newest_setpoints.hpp"
#include "casd/words/drop_cause.hpp"

namespace cas::casd {

/// How old packets may grow in a TxQueue, and how much memory each class may take.
struct TxQueueOptions {
  base::Duration hil_max_age = std::chrono::milliseconds(25);
  base::Duration gps_max_age = std::chrono::milliseconds(400);
  /// The time after which PX4 takes sticks for lost.
  base::Duration setpoint_max_age = std::chrono::milliseconds(500);
  base::Duration telemetry_max_age = std::chrono::seconds(1);
  // Memory of each class of packets:
  std::size_t command_bytes = 256 * 1024;
  std::size_t hil_bytes = 1024 * 1024;
  std::size_t gps_bytes = 32 * 1024;
  std::size_t telemetry_bytes = 256 * 1024;

  /// Would a packet that is handed to `line` now arrive too late?
  bool too_late(const PacketInfo& info, std::size_t size, base::RunTime now,
                const LinePacer& line) const;

  friend bool operator==(const TxQueueOptions&, const TxQueueOptions&) = default;
};

/// Packets that wait for a link, by class, each class with memory of its own.
///
///   command    FIFO; a new one is refused only when the class is full; never dropped once in
///   hil        FIFO; dropped only when it could no longer arrive within its age limit (or, as the
///              last resort, the oldest for lack of memory)
///   gps        the same with a longer limit
///   setpoint   the newest of each stream only, dropped like hil with a longer limit
///   telemetry  goes when nothing else waits; old ones make room for new ones
///
/// Command, hil, gps and setpoint share the line by bytes, 4 : 8 : 2 : 4 while all of them wait
/// (fair queueing by virtual time): no class starves another.
class TxQueue {
 public:
  using OnDrop = std::function<void(const PacketInfo&, DropCause)>;

  explicit TxQueue(const TxQueueOptions& options = {}, OnDrop on_drop = {});

  /// Copies the packet in. @return false when it was refused (and counted)
  bool push(const PacketInfo& info, std::span<const std::uint8_t> bytes);
  /// The packet whose turn it is, taken out; its bytes hold until the next push or pop. Packets
  /// that would arrive too late over `line` are dropped on the way.
  std::optional<QueuedPacket> pop(base::RunTime now, const LinePacer& line);
  /// Drops everything: the link went away.
  void clear(DropCause cause);

  bool empty() const { return count() == 0; }
  std::size_t count() const;
  std::size_t high_water() const { return high_water_; }  ///< most packets that ever waited

 private:
  void drop_late(base::RunTime now, const LinePacer& line);
  std::optional<TrafficClass> next_class() const;
  bool waits(TrafficClass traffic) const;
  QueuedPacket take(TrafficClass traffic);
  void drop_front(TrafficClass traffic, DropCause cause);
  PacketRing& ring(TrafficClass traffic) { return rings_[static_cast<std::size_t>(traffic)]; }
  const PacketRing& ring(TrafficClass traffic) const {
    return rings_[static_cast<std::size_t>(traffic)];
  }

  TxQueueOptions options_;
  OnDrop on_drop_;
  std::array<PacketRing, kTrafficClasses> rings_;  ///< that of the setpoints stays empty
  NewestSetpoints setpoints_;
  std::array<double, kTrafficClasses> virtual_time_{};
  double virtual_now_ = 0;
  std::size_t high_water_ = 0;
};

}  // namespace cas::casd
