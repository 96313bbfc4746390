// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "base/clock.hpp"

namespace cas::base {

/// The clock of a program in lockstep: the time of the sensor stream that it sees, in place of the
/// steady clock. It stands still while the simulation does, and it never goes back: when the
/// simulation starts anew, the clock goes on from where it was.
class StreamClock {
 public:
  /// A HIL_SENSOR with this stamp has come.
  void on_sensor(std::uint64_t time_usec) {
    if (time_usec > kLatestTimeUsec) return;
    if (time_usec < last_usec_) {
      // Several vehicles' messages of one step may overtake each other; a jump back is a new run.
      if (last_usec_ - time_usec < kRestartUsec) return;
      before_usec_ += last_usec_;
    }
    last_usec_ = time_usec;
  }

  /// The newest stamp, with the length of the runs before this one.
  RunTime now() const { return RunTime(std::chrono::microseconds(before_usec_ + last_usec_)); }

 private:
  static constexpr std::uint64_t kRestartUsec = 1'000'000;

  std::uint64_t before_usec_ = 0;  // length of the runs before this one
  std::uint64_t last_usec_ = 0;
};

}  // namespace cas::base
