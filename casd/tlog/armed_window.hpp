// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <optional>

#include "base/time/clock.hpp"

namespace cas::casd {

/// The stretch of time that is a flight: from the first vehicle's arming until a moment after the
/// last one has disarmed. Pure.
class ArmedWindow {
 public:
  /// The moments after the disarming show why it came, and how the vehicle came to rest.
  static constexpr base::Duration kAfter = std::chrono::seconds(1);

  /// @return whether it is open
  bool update(bool any_armed, base::RunTime now) {
    if (any_armed) {
      open_ = true;
      disarmed_at_.reset();
    } else if (open_) {
      if (!disarmed_at_) disarmed_at_ = now;
      open_ = now - *disarmed_at_ < kAfter;
    }
    return open_;
  }

 private:
  bool open_ = false;
  std::optional<base::RunTime> disarmed_at_;
};

}  // namespace cas::casd
