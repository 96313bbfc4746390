// SPDX-License-Identifier: BSD-3-Clause
#include "casd/counters/echo_latency.hpp"

#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::casd {
namespace {

/// The stamp, never 0: that is a free place.
std::uint64_t key_of(const PacketInfo& packet) { return packet.hil_time_usec << 1U | 1U; }

}  // namespace

void EchoLatency::on_packet(const PacketInfo& packet, base::RunTime now) {
  switch (packet.message_id) {
    case mavlink::common::HilSensor::kId:
      return on_sensor(key_of(packet), packet.source.system, now);
    case mavlink::common::HilControls::kId:
    case mavlink::common::HilActuatorControls::kId:
      return on_controls(key_of(packet), packet.source.system, now);
    default:
      return;
  }
}

void EchoLatency::on_sensor(std::uint64_t key, std::uint8_t system, base::RunTime now) {
  Stamps* const stamps = stamps_of(system);
  if (stamps == nullptr) return;
  Sent& sent = (*stamps)[place_of(key)];
  sent.key.store(0, std::memory_order_relaxed);  // no other thread takes the old key's new time
  sent.at_ns.store(now.time_since_epoch().count(), std::memory_order_release);
  sent.key.store(key, std::memory_order_release);
}

void EchoLatency::on_controls(std::uint64_t key, std::uint8_t system, base::RunTime now) {
  std::int64_t at_ns = 0;
  const bool matched = matches(key, system, at_ns);
  const base::MutexLock lock(mutex_);
  if (!vehicles_.contains(system) && vehicles_.size() == kMaxVehicles) return;
  Vehicle& vehicle = vehicles_[system];
  if (matched) {
    vehicle.times.add(now - base::RunTime(base::Duration(at_ns)));
  } else {
    ++vehicle.unmatched;
  }
}

/// Whether a simulator sent this stamp. @param at_ns  when
bool EchoLatency::matches(std::uint64_t key, std::uint8_t system, std::int64_t& at_ns) const {
  const Stamps* const stamps = sent_[system].load(std::memory_order_acquire);
  if (stamps == nullptr) return false;
  const Sent& sent = (*stamps)[place_of(key)];
  const bool found = sent.key.load(std::memory_order_acquire) == key;
  at_ns = sent.at_ns.load(std::memory_order_acquire);
  return found && sent.key.load(std::memory_order_relaxed) == key;
}

/// @return nullptr when there are too many vehicles
EchoLatency::Stamps* EchoLatency::stamps_of(std::uint8_t system) {
  if (Stamps* const stamps = sent_[system].load(std::memory_order_acquire)) return stamps;
  const base::MutexLock lock(mutex_);
  if (Stamps* const stamps = sent_[system].load(std::memory_order_relaxed)) return stamps;
  if (owned_.size() == kMaxVehicles) return nullptr;
  Stamps* const stamps = owned_.emplace_back(std::make_unique<Stamps>()).get();
  sent_[system].store(stamps, std::memory_order_release);
  return stamps;
}

std::size_t EchoLatency::place_of(std::uint64_t key) {
  constexpr std::uint64_t kMultiplier = 0x9E3779B97F4A7C15ULL;  // spreads neighbouring keys
  static_assert(kStamps == std::size_t{1} << 10U);
  return (key * kMultiplier) >> 54U;
}

std::vector<EchoLatency::Figures> EchoLatency::figures() const {
  const base::MutexLock lock(mutex_);
  std::vector<Figures> all;
  for (const auto& [system, vehicle] : vehicles_) {
    all.push_back({.system = system,
                   .matched = vehicle.times.count(),
                   .unmatched = vehicle.unmatched,
                   .p50 = vehicle.times.quantile(0.50),
                   .p99 = vehicle.times.quantile(0.99),
                   .max = vehicle.times.max()});
  }
  return all;
}

}  // namespace cas::casd
