// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <compare>

namespace cas::mav::services {

/// Every duration in the interfaces of the services: whole nanoseconds.
using Duration = std::chrono::nanoseconds;

/// A moment by the caller's clock, std::chrono::steady_clock or a simulated one; only differences
/// of two have a meaning. Services read no clock: `now` is an argument.
class Time {
 public:
  constexpr Time() = default;
  constexpr explicit Time(Duration since_zero) : since_zero_(since_zero) {}
  /// From and to any clock of <chrono>, by itself.
  template <class Clock, class D>
  constexpr Time(std::chrono::time_point<Clock, D> moment)
      : since_zero_(std::chrono::duration_cast<Duration>(moment.time_since_epoch())) {}
  template <class Clock>
  constexpr operator std::chrono::time_point<Clock, Duration>() const {
    return std::chrono::time_point<Clock, Duration>(since_zero_);
  }

  constexpr Duration time_since_epoch() const { return since_zero_; }

  constexpr Time& operator+=(Duration d) {
    since_zero_ += d;
    return *this;
  }
  friend constexpr Time operator+(Time t, Duration d) { return Time(t.since_zero_ + d); }
  friend constexpr Time operator-(Time t, Duration d) { return Time(t.since_zero_ - d); }
  friend constexpr Duration operator-(Time a, Time b) { return a.since_zero_ - b.since_zero_; }
  friend constexpr auto operator<=>(Time, Time) = default;

 private:
  Duration since_zero_{};
};

}  // namespace cas::mav::services
