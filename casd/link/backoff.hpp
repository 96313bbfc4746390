// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>

#include "base/time/clock.hpp"

namespace cas::casd {

/// When to try again: after 50 ms, then twice as long each time, up to 1 s.
class Backoff {
 public:
  static constexpr base::Duration kFirst = std::chrono::milliseconds(50);
  static constexpr base::Duration kLongest = std::chrono::seconds(1);

  bool due(base::RunTime now) const { return now >= next_; }
  base::RunTime next() const { return next_; }
  /// An attempt failed.
  void failed(base::RunTime now) {
    next_ = now + delay_;
    delay_ = std::min(2 * delay_, kLongest);
  }
  /// It worked, or there is reason to believe that it will.
  void reset() {
    delay_ = kFirst;
    next_ = base::RunTime{};
  }

 private:
  base::RunTime next_{};
  base::Duration delay_ = kFirst;
};

}  // namespace cas::casd
