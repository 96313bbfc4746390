// SPDX-License-Identifier: BSD-3-Clause
#include "casd/queue/tx_queue.hpp"

#include <algorithm>

namespace cas::casd {
namespace {

using enum TrafficClass;

// Share of the line in bytes while several classes wait; telemetry has none.
constexpr std::array<double, kTrafficClasses> kWeights{4, 8, 2, 0};
// Who goes first among equals: the rarer and smaller traffic.
constexpr std::array kByRank{kCommand, kGps, kHil};

constexpr std::size_t index(TrafficClass traffic) { return static_cast<std::size_t>(traffic); }

// Part of an age limit that is left to what comes behind us: the driver, the receiver's wake-up.
constexpr int kGuardDivisor = 8;

}  // namespace

std::string_view to_string(DropCause cause) {
  switch (cause) {
    case DropCause::kAge:
      return "age";
    case DropCause::kBandwidth:
      return "bandwidth";
    case DropCause::kQueueFull:
      return "queue_full";
    case DropCause::kClosed:
      return "closed";
    case DropCause::kStalled:
      return "stalled";
    case DropCause::kUnsignable:
      return "unsignable";
  }
  return "?";
}

TxQueue::TxQueue(const TxQueueOptions& options, OnDrop on_drop)
    : options_(options),
      on_drop_(std::move(on_drop)),
      rings_{PacketRing(options.command_bytes), PacketRing(options.hil_bytes),
             PacketRing(options.gps_bytes), PacketRing(options.telemetry_bytes)} {}

bool TxQueue::push(const PacketInfo& info, std::span<const std::uint8_t> bytes) {
  const TrafficClass traffic = info.traffic;
  const bool was_idle = ring(traffic).empty();
  while (!ring(traffic).push(info, bytes)) {
    if (traffic == kCommand || ring(traffic).empty()) {
      if (on_drop_) on_drop_(info, DropCause::kQueueFull);
      return false;
    }
    drop_front(traffic, DropCause::kQueueFull);
  }
  // A class that was idle starts level with the others: idle time earns no credit.
  double& own_time = virtual_time_[index(traffic)];
  if (was_idle) own_time = std::max(own_time, virtual_now_);
  high_water_ = std::max(high_water_, count());
  return true;
}

std::optional<QueuedPacket> TxQueue::pop(base::RunTime now, const LinePacer& line) {
  drop_late(now, line);
  const std::optional<TrafficClass> traffic = next_class();
  if (!traffic) return std::nullopt;
  const QueuedPacket packet = ring(*traffic).front();
  ring(*traffic).pop();
  if (*traffic != kTelemetry) {
    double& own_time = virtual_time_[index(*traffic)];
    virtual_now_ = own_time;
    own_time += static_cast<double>(packet.bytes.size()) / kWeights[index(*traffic)];
  }
  return packet;
}

void TxQueue::clear(DropCause cause) {
  for (const TrafficClass traffic : {kCommand, kHil, kGps, kTelemetry}) {
    while (!ring(traffic).empty()) drop_front(traffic, cause);
  }
}

std::size_t TxQueue::count() const {
  std::size_t sum = 0;
  for (const PacketRing& one : rings_) sum += one.count();
  return sum;
}

void TxQueue::drop_late(base::RunTime now, const LinePacer& line) {
  for (const TrafficClass traffic : {kHil, kGps, kTelemetry}) {
    while (!ring(traffic).empty()) {
      const QueuedPacket oldest = ring(traffic).front();
      if (!too_late(oldest.info, oldest.bytes.size(), now, line)) break;
      drop_front(traffic, DropCause::kAge);
    }
  }
}

bool TxQueue::too_late(const PacketInfo& info, std::size_t size, base::RunTime now,
                       const LinePacer& line) const {
  if (info.traffic == kCommand) return false;
  const base::Duration limit = info.traffic == kHil   ? options_.hil_max_age
                               : info.traffic == kGps ? options_.gps_max_age
                                                      : options_.telemetry_max_age;
  // A line so slow that one packet takes most of the limit still gets the newest one.
  const base::Duration allowed = std::max(limit - limit / kGuardDivisor, 2 * line.time_for(size));
  return line.arrival(size, now) - info.received > allowed;
}

std::optional<TrafficClass> TxQueue::next_class() const {
  std::optional<TrafficClass> best;
  for (const TrafficClass traffic : kByRank) {
    if (ring(traffic).empty()) continue;
    if (!best || virtual_time_[index(traffic)] < virtual_time_[index(*best)]) best = traffic;
  }
  if (!best && !ring(kTelemetry).empty()) best = kTelemetry;
  return best;
}

void TxQueue::drop_front(TrafficClass traffic, DropCause cause) {
  if (on_drop_) on_drop_(ring(traffic).front().info, cause);
  ring(traffic).pop();
}

}  // namespace cas::casd
