// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/packet_account.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace cas::hils {

namespace {

using Direction = base::LedgerEntry::Direction;

/// The sender must outlive the window by this much of its own stamps before the pipe counts as
/// drained: more than any queue of the chain keeps a packet.
constexpr std::uint64_t kDrainUsec = 500'000;

/// First occurrence of each stamp: time_usec -> moment.
using Moments = std::unordered_map<std::uint64_t, std::int64_t>;

Moments moments(std::span<const base::LedgerEntry> ledger, Direction direction,
                std::uint32_t message_id) {
  Moments found;
  for (const base::LedgerEntry& entry : ledger) {
    if (entry.direction == direction && entry.message_id == message_id) {
      found.try_emplace(entry.time_usec, entry.at_ns);
    }
  }
  return found;
}

std::uint64_t last_stamp(std::span<const base::LedgerEntry> ledger) {
  std::uint64_t last = 0;
  for (const base::LedgerEntry& entry : ledger) {
    if (entry.direction == Direction::kSent) last = std::max(last, entry.time_usec);
  }
  return last;
}

/// Delays between equal stamps, in the order of the stamps.
std::vector<std::int64_t> delays(const Moments& from, const Moments& to, StreamWindow window) {
  std::vector<std::pair<std::uint64_t, std::int64_t>> stamped;
  for (const auto& [stamp, arrived] : to) {
    if (!window.holds(stamp)) continue;
    const auto departed = from.find(stamp);
    if (departed != from.end()) stamped.emplace_back(stamp, arrived - departed->second);
  }
  std::ranges::sort(stamped);
  std::vector<std::int64_t> result;
  result.reserve(stamped.size());
  for (const auto& [stamp, delay] : stamped) result.push_back(delay);
  return result;
}

double microseconds(std::int64_t ns) { return static_cast<double>(ns) / 1000.0; }

}  // namespace

RateFigures account(std::span<const base::LedgerEntry> sender,
                    std::span<const base::LedgerEntry> receiver, std::uint32_t message_id,
                    StreamWindow window, double nominal_hz) {
  const Moments sent = moments(sender, Direction::kSent, message_id);
  RateFigures figures;
  figures.nominal_hz = nominal_hz;
  figures.sent = static_cast<std::uint64_t>(
      std::ranges::count_if(sent, [&](const auto& entry) { return window.holds(entry.first); }));
  figures.drained = last_stamp(sender) >= window.end_usec + kDrainUsec;

  Moments arrived;
  std::int64_t first = std::numeric_limits<std::int64_t>::max();
  std::int64_t last = std::numeric_limits<std::int64_t>::min();
  for (const base::LedgerEntry& entry : receiver) {
    if (entry.direction != Direction::kReceived || entry.message_id != message_id) continue;
    if (!window.holds(entry.time_usec)) continue;
    if (!arrived.try_emplace(entry.time_usec, entry.at_ns).second) {
      ++figures.duplicated;
      continue;
    }
    if (!sent.contains(entry.time_usec)) ++figures.unexplained;
    first = std::min(first, entry.at_ns);
    last = std::max(last, entry.at_ns);
  }
  figures.received = arrived.size() - figures.unexplained;
  figures.lost = figures.sent - figures.received;
  if (arrived.size() >= 2 && last > first) {
    figures.received_hz =
        static_cast<double>(arrived.size() - 1) / (static_cast<double>(last - first) * 1e-9);
  }
  figures.error_pct = 100.0 * (nominal_hz - figures.received_hz) / nominal_hz;
  return figures;
}

DelayFigures summarise(std::vector<std::int64_t> delays_ns) {
  DelayFigures figures;
  if (delays_ns.empty()) return figures;
  std::ranges::sort(delays_ns);
  const auto at = [&](double q) {  // nearest rank
    const auto n = static_cast<double>(delays_ns.size());
    const auto rank = static_cast<std::size_t>(std::max(1.0, std::ceil(q * n)));
    return microseconds(delays_ns[rank - 1]);
  };
  figures.count = delays_ns.size();
  figures.p50 = at(0.50);
  figures.p90 = at(0.90);
  figures.p99 = at(0.99);
  figures.max = microseconds(delays_ns.back());
  return figures;
}

std::vector<std::int64_t> delays_ns(const LedgerView& from, const LedgerView& to,
                                    StreamWindow window) {
  return delays(moments(from.ledger, from.direction, from.message_id),
                moments(to.ledger, to.direction, to.message_id), window);
}

std::vector<std::int64_t> echo_delays_ns(std::span<const base::LedgerEntry> ledger,
                                         std::uint32_t sensor_id, std::uint32_t controls_id,
                                         StreamWindow window) {
  return delays(moments(ledger, Direction::kSent, sensor_id),
                moments(ledger, Direction::kReceived, controls_id), window);
}

std::vector<std::int64_t> hop_delays_ns(std::span<const base::LedgerEntry> sender,
                                        std::span<const base::LedgerEntry> receiver,
                                        std::uint32_t message_id, StreamWindow window) {
  return delays(moments(sender, Direction::kSent, message_id),
                moments(receiver, Direction::kReceived, message_id), window);
}

PaceFigures pace(std::span<const base::LedgerEntry> sender, std::uint32_t message_id,
                 StreamWindow window) {
  PaceFigures figures;
  std::int64_t least_lag = std::numeric_limits<std::int64_t>::max();
  std::int64_t most_lag = std::numeric_limits<std::int64_t>::min();
  const base::LedgerEntry* first = nullptr;
  const base::LedgerEntry* last = nullptr;
  for (const base::LedgerEntry& entry : sender) {
    if (entry.direction != Direction::kSent || entry.message_id != message_id) continue;
    if (!window.holds(entry.time_usec)) continue;
    if (first == nullptr) first = &entry;
    last = &entry;
    const std::int64_t lag = entry.at_ns - static_cast<std::int64_t>(entry.time_usec) * 1000;
    least_lag = std::min(least_lag, lag);
    most_lag = std::max(most_lag, lag);
  }
  if (first == nullptr || last->at_ns <= first->at_ns) return figures;
  figures.real_time_factor = static_cast<double>(last->time_usec - first->time_usec) * 1000.0 /
                             static_cast<double>(last->at_ns - first->at_ns);
  figures.worst_stall_ms = static_cast<double>(most_lag - least_lag) * 1e-6;
  return figures;
}

}  // namespace cas::hils
