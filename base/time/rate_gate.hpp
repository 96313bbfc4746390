// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "base/time/clock.hpp"

namespace cas::base {

__extension__ using Int128 = __int128;  // products of nanoseconds and rates

/// Says when something with a rate is due, exactly in count on any grid of steps: whenever
/// floor(t x rate) advances. 400 Hz on a 500 Hz grid fires after 4, 2, 2, 2 ms; no sum is kept.
class RateGate {
 public:
  RateGate() = default;
  /// @param rate_hz  0 means never; resolved to 1 mHz
  explicit RateGate(double rate_hz) : rate_mhz_(std::llround(rate_hz * 1000.0)) {}

  /// True once per period; a gap of several periods counts as one.
  bool due(SimTime t) { return due(t.time_since_epoch()); }
  /// The same for a time since the start of the run.
  bool due(Duration since_start) {
    const std::int64_t index = index_at(since_start);
    if (index <= last_) return false;
    last_ = index;
    return true;
  }

  /// floor(t x rate): the number of periods completed at `since_start`.
  std::int64_t index_at(Duration since_start) const {
    return static_cast<std::int64_t>(static_cast<Int128>(since_start.count()) * rate_mhz_ /
                                     1'000'000'000'000);
  }

  /// The rate after rounding to 1 mHz.
  double rate_hz() const { return static_cast<double>(rate_mhz_) / 1000.0; }
  /// Back to time zero.
  void reset() { last_ = 0; }

 private:
  std::int64_t rate_mhz_ = 0;
  std::int64_t last_ = 0;
};

}  // namespace cas::base
