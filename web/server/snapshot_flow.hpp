// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "base/time/clock.hpp"

namespace cas::web {

/// When one page may get the next snapshot of one topic: after it has acknowledged the last one,
/// and no sooner than its rate says. So a slow page gets fewer and newer ones, and has no queue to
/// fall behind in. Pure.
class SnapshotFlow {
 public:
  explicit SnapshotFlow(double hz) { set_rate(hz); }

  /// Keeps snapshots in flight.
  void set_rate(double hz) { period_ = base::from_seconds(1 / hz); }

  /// Whether to send a present snapshot. A little early counts as on time, so that the jitter of
  /// timers halves no rate.
  bool wants(base::RunTime now) const {
    constexpr base::Duration kJitter = std::chrono::milliseconds(5);
    return !in_flight_ && now + std::min(period_ / 4, kJitter) >= next_;
  }
  /// Whether one will be wanted without another acknowledgement.
  bool waits() const { return !in_flight_; }
  void on_sent(std::uint64_t seq, base::RunTime now) {
    in_flight_ = seq;
    next_ = std::max(next_ + period_, now);
  }
  /// The page has drawn it. @return whether it was the one in flight
  bool on_ack(std::uint64_t seq) {
    if (in_flight_ != seq) return false;
    in_flight_.reset();
    return true;
  }

 private:
  base::Duration period_{};
  base::RunTime next_{};  // earliest moment of the next
  std::optional<std::uint64_t> in_flight_;
};

}  // namespace cas::web
