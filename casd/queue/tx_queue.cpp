// SPDX-License-Identifier: BSD-3-Clause
#include "casd/queue/tx_queue.hpp"

#include <algorithm>

namespace cas::casd {
namespace {

using enum TrafficClass;

// Share of the line in bytes while several classes wait; telemetry has none.
constexpr std::array<double, kTrafficClasses> kWeights{4, 8, 2, 4, 0};
// Order among equals: rarer and smaller traffic first.
constexpr std::array kByRank{kSetpoint, kCommand, kGps, kHil};

constexpr std::size_t index(TrafficClass traffic) { return static_cast<std::size_t>(traffic); }

// Part of an age limit that is reserved for later delays: the driver, the receiver's wake-up.
constexpr int kGuardDivisor = 8;

}  // namespace

TxQueue::TxQueue(const TxQueueOptions& options, OnDrop on_drop)
    : options_(options),
      on_drop_(std::move(on_drop)),
      rings_{PacketRing(options.command_bytes), PacketRing(options.hil_bytes),
             PacketRing(options.gps_bytes), PacketRing(0), PacketRing(options.telemetry_bytes)} {}

bool TxQueue::push(const PacketInfo& info, std::span<const std::uint8_t> bytes) {
  const TrafficClass traffic = info.traffic;
  const bool was_idle = !waits(traffic);
  if (traffic == kSetpoint) setpoints_.push(info, bytes, on_drop_);
  while (traffic != kSetpoint && !ring(traffic).push(info, bytes)) {
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
  const QueuedPacket packet = take(*traffic);
  if (*traffic != kTelemetry) {
    double& own_time = virtual_time_[index(*traffic)];
    virtual_now_ = own_time;
    own_time += static_cast<double>(packet.bytes.size()) / kWeights[index(*traffic)];
  }
  return packet;
}

void TxQueue::clear(DropCause cause) {
  for (const TrafficClass traffic : {kCommand, kHil, kGps, kSetpoint, kTelemetry}) {
    while (waits(traffic)) drop_front(traffic, cause);
  }
}

std::size_t TxQueue::count() const {
  std::size_t sum = setpoints_.count();
  for (const PacketRing& one : rings_) sum += one.count();
  return sum;
}

void TxQueue::drop_late(base::RunTime now, const LinePacer& line) {
  for (const TrafficClass traffic : {kHil, kGps, kTelemetry}) {
    while (!ring(traffic).empty()) {
      const QueuedPacket oldest = ring(traffic).front();
      if (!options_.too_late(oldest.info, oldest.bytes.size(), now, line)) break;
      drop_front(traffic, DropCause::kAge);
    }
  }
  const auto late = [&](const PacketInfo& info, std::size_t size) {
    return options_.too_late(info, size, now, line);
  };
  setpoints_.drop_late(late, on_drop_);
}

bool TxQueueOptions::too_late(const PacketInfo& info, std::size_t size, base::RunTime now,
                              const LinePacer& line) const {
  if (info.traffic == kCommand) return false;
  const base::Duration limit = info.traffic == kHil        ? hil_max_age
                               : info.traffic == kGps      ? gps_max_age
                               : info.traffic == kSetpoint ? setpoint_max_age
                                                           : telemetry_max_age;
  // A line so slow that one packet takes most of the limit still gets the newest one.
  const base::Duration allowed = std::max(limit - limit / kGuardDivisor, 2 * line.time_for(size));
  return line.arrival(size, now) - info.received + info.waited > allowed;
}

std::optional<TrafficClass> TxQueue::next_class() const {
  std::optional<TrafficClass> best;
  for (const TrafficClass traffic : kByRank) {
    if (!waits(traffic)) continue;
    if (!best || virtual_time_[index(traffic)] < virtual_time_[index(*best)]) best = traffic;
  }
  if (!best && !ring(kTelemetry).empty()) best = kTelemetry;
  return best;
}

bool TxQueue::waits(TrafficClass traffic) const {
  return traffic == kSetpoint ? !setpoints_.empty() : !ring(traffic).empty();
}

QueuedPacket TxQueue::take(TrafficClass traffic) {
  if (traffic == kSetpoint) return setpoints_.pop();
  const QueuedPacket packet = ring(traffic).front();
  ring(traffic).pop();
  return packet;
}

void TxQueue::drop_front(TrafficClass traffic, DropCause cause) {
  const QueuedPacket packet = take(traffic);
  if (on_drop_) on_drop_(packet.info, cause);
}

}  // namespace cas::casd
