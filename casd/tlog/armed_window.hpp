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
  /// What follows the disarming is of interest, too: why, and how it came to rest.
  static constexpr base::Duration kAfter = std::chrono::seconds(1);

  /// @return whether it is open
  bool update(bool any_armed, base::RunTime now) {
    if (any_armed) {
      open_until_ = now + kAfter;
    } else if (open_until_ && now >= *open_until_) {
      open_until_.reset();
    }
    return open_until_.has_value();
  }

 private:
  std::optional<base::RunTime> open_until_;
};

}  // namespace cas::casd
