// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>

#include "base/time/clock.hpp"

namespace cas::casd {

/// Which of many like lines go to the log: so many a minute, then one that says that others are
/// left out. The log of a service has room for so many lines, and others need it. Pure.
class LogThinning {
 public:
  static constexpr int kLines = 20;
  static constexpr base::Duration kPeriod = std::chrono::minutes(1);
  enum class Verdict : std::uint8_t { kWrite, kLast, kLeaveOut };

  Verdict on_line(base::RunTime now) {
    if (lines_ == 0 || now - since_ >= kPeriod) {
      since_ = now;
      lines_ = 0;
    }
    if (lines_ == kLines) return Verdict::kLeaveOut;
    return ++lines_ == kLines ? Verdict::kLast : Verdict::kWrite;
  }

 private:
  base::RunTime since_{};
  int lines_ = 0;
};

}  // namespace cas::casd
