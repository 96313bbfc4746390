// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/time/clock.hpp"

namespace cas::base {

/// The clock of a program in lockstep: the time of the sensor stream that it sees, in place of the
/// steady clock. It stands still while the simulation does, and it never goes back: when the
/// simulation restarts, the clock goes on from its last value.
///
/// Any stamp will do, also microseconds or nanoseconds since 1970: only differences are counted. A
/// first stamp below one hour counts in full; of a later one only the part beyond its last full
/// second counts, and only once the next stamp confirms that it was not corrupt.
class StreamClock {
 public:
  /// A HIL_SENSOR with this stamp has come.
  void on_sensor(std::uint64_t time_usec) {
    if (follows(last_usec_, time_usec)) {
      add(time_usec - last_usec_);
    } else if (time_usec < last_usec_ && last_usec_ - time_usec < kRestartUsec) {
      return;  // several vehicles' messages of one step may overtake each other
    } else if (time_usec < kFarUsec) {
      add(time_usec);  // a new run
    } else if (far_usec_ == 0 || !follows(far_usec_, time_usec)) {
      far_usec_ = time_usec;
      return;
    } else {
      add(far_usec_ % kRestartUsec + (time_usec - far_usec_));
    }
    last_usec_ = time_usec;
    far_usec_ = 0;
  }

  /// The time of the stream since its first run began.
  RunTime now() const { return RunTime(std::chrono::microseconds(now_usec_)); }

 private:
  static constexpr std::uint64_t kRestartUsec = 1'000'000;  ///< a jump back this far: a new run
  static constexpr std::uint64_t kFarUsec = 3'600'000'000;  ///< and so is one forward this far

  static bool follows(std::uint64_t before, std::uint64_t usec) {
    return usec >= before && usec - before < kFarUsec;
  }

  void add(std::uint64_t usec) { now_usec_ = std::min(now_usec_ + usec, kLatestTimeUsec); }

  std::uint64_t now_usec_ = 0;
  std::uint64_t last_usec_ = 0;
  std::uint64_t far_usec_ = 0;  // a stamp far from the last one, not yet confirmed; 0: none
};

}  // namespace cas::base
