// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "base/time/clock.hpp"

namespace cas::base::rpc {

/// How fast the lines of one client are read, or clients accepted: so many a second, and as many at
/// once after a rest.
class LineRate {
 public:
  LineRate(double max_lines_s, RunTime now)
      : max_lines_s_(max_lines_s), credit_lines_(max_lines_s), credited_(now) {}

  /// A line was read. @return how long to wait before the next one is read; zero: not at all
  Duration take(RunTime now) {
    const double earned = to_seconds(now - credited_) * max_lines_s_;
    credited_ = now;
    credit_lines_ = std::min(max_lines_s_, credit_lines_ + earned) - 1;
    return credit_lines_ >= 0 ? Duration::zero() : from_seconds(-credit_lines_ / max_lines_s_);
  }

 private:
  double max_lines_s_;
  double credit_lines_;
  RunTime credited_;
};

}  // namespace cas::base::rpc
