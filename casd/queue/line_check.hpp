// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>

#include "base/time/clock.hpp"

namespace cas::casd {

/// The look at the line before a paced write ([HILS] Sect. 3.3): how many bytes the driver has not
/// yet put on it. A line slower than its rate, or held by flow control, shows here before anything
/// is lost.
///
/// Not every driver tells the truth. One whose figure stands still above zero for longer than any
/// line without flow control can need is not believed any more.
class LineCheck {
 public:
  static constexpr base::Duration kPatience = std::chrono::seconds(2);

  /// @param may_stand_still  flow control: the other side may hold the line as long as it likes
  explicit LineCheck(bool may_stand_still = false) : may_stand_still_(may_stand_still) {}

  /// @return the bytes to wait for: `unsent`, or 0 from a driver that is not believed
  std::size_t believed(std::size_t unsent, base::RunTime now) {
    if (unsent == 0 || unsent != last_) since_ = now;
    last_ = unsent;
    if (!may_stand_still_ && now - since_ > kPatience) trusted_ = false;
    return trusted_ ? unsent : 0;
  }
  /// Something was written: a figure that does not change may be of new bytes.
  void wrote(base::RunTime now) { since_ = now; }
  /// A fresh line.
  void reset() { *this = LineCheck(may_stand_still_); }

 private:
  bool may_stand_still_;
  bool trusted_ = true;
  std::size_t last_ = 0;
  base::RunTime since_{};
};

}  // namespace cas::casd
