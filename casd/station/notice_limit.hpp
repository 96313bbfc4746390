// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

#include "base/time/clock.hpp"

namespace cas::casd {

/// Bounds how many lines of the log others can cause: so many in a minute. Pure.
class NoticeLimit {
 public:
  static constexpr base::Duration kStretch = std::chrono::minutes(1);

  explicit NoticeLimit(int most) : most_(most) {}

  /// Counts a line. @return whether it may be written
  bool take(base::RunTime now) {
    if (now - since_ > kStretch) {
      since_ = now;
      count_ = 0;
    }
    return ++count_ <= most_;
  }
  /// Whether the line that was counted last is the last one of its minute.
  bool is_last() const { return count_ == most_; }

 private:
  int most_;
  int count_ = 0;
  base::RunTime since_{};
};

}  // namespace cas::casd
