// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>

#include "base/time/clock.hpp"

namespace cas::sim {

/// Backlog of a serial line: the moment at which it has sent all bytes that were handed to it, at
/// ten bits a byte. Pure.
class LineBudget {
 public:
  /// @param baud  0: a line without a rate of its own (USB)
  explicit LineBudget(unsigned baud) : baud_(baud) {}

  base::Duration time_of(std::size_t bytes) const {
    if (baud_ == 0) return {};
    constexpr base::Duration::rep kBitsPerByte = 10;
    const auto bits = static_cast<base::Duration::rep>(bytes) * kBitsPerByte;
    return base::Duration(bits * 1'000'000'000 / baud_);
  }
  /// Time until the line is free.
  base::Duration backlog(base::SimTime now) const {
    return std::max(base::Duration(0), free_at_ - now);
  }
  void add(base::SimTime now, std::size_t bytes) {
    free_at_ = std::max(free_at_, now) + time_of(bytes);
  }
  /// The driver knows of bytes that it has not sent yet: the line is busy for them at least.
  void add_unsent(base::SimTime now, std::size_t bytes) {
    free_at_ = std::max(free_at_, now + time_of(bytes));
  }
  void reset() { free_at_ = {}; }

 private:
  base::Duration::rep baud_;
  base::SimTime free_at_{};
};

}  // namespace cas::sim
