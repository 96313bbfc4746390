// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>

#include "base/time/clock.hpp"

namespace cas::casd {

/// How often a thread looks at its links while they are flooded.
///
/// Up to kBusyPackets a millisecond each packet is forwarded the moment it comes. What brings more
/// is looked at once in kPause: then several packets are read, routed and written with a system
/// call each time instead of one each, and who sends does not pay for waking this thread with every
/// packet. Network cards moderate their interrupts in the same way. A HIL link of 500 Hz, and a
/// lockstep run that waits for each answer, stay far below. kPause was chosen with the closed loop
/// of scripts/bench_router: with half of it a PTY still brings few packets at a look, a longer one
/// delays more and gains little.
class LookPace {
 public:
  static constexpr std::uint64_t kBusyPackets = 50;  ///< in kSpan
  static constexpr base::Duration kSpan = std::chrono::milliseconds(1);
  static constexpr base::Duration kPause = std::chrono::microseconds(150);

  /// @param received  packets that have come so far, all links of the thread together
  void looked(base::RunTime now, std::uint64_t received) {
    last_look_ = now;
    const base::Duration elapsed = now - span_begin_;
    if (elapsed < kSpan) return;
    // A link that was taken away takes its packets along.
    const std::uint64_t came = received > received_before_ ? received - received_before_ : 0;
    busy_ = came * kSpan > kBusyPackets * elapsed;
    span_begin_ = now;
    received_before_ = received;
  }

  /// Not before this: in the past, or not long ago, unless there is a flood.
  base::RunTime next_look() const { return busy_ ? last_look_ + kPause : last_look_; }

 private:
  base::RunTime span_begin_{};
  base::RunTime last_look_{};
  std::uint64_t received_before_ = 0;
  bool busy_ = false;
};

}  // namespace cas::casd
