// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "base/export.hpp"

namespace cas::base {

/// Every duration in the interfaces of CAS: whole nanoseconds.
using Duration = std::chrono::nanoseconds;

/// Simulated time since the start of a run. It has no `now()`: it arrives as an argument.
struct SimClock {
  using duration = Duration;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<SimClock>;
  static constexpr bool is_steady = true;
};
/// A moment of simulated time, from the start of the run.
using SimTime = SimClock::time_point;

/// Time of the program that decides: the steady clock in real time, the stream's time in lockstep,
/// the virtual clock in a direct run. It has no `now()` either; a shell reads `steady_now()` and
/// passes it on.
struct RunClock {
  using duration = Duration;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<RunClock>;
  static constexpr bool is_steady = true;
};
/// A moment of the program's time; only differences of two mean anything.
using RunTime = RunClock::time_point;

/// CLOCK_MONOTONIC as a RunTime. For shells (sockets, PTYs, pacers) only.
CAS_BASE_EXPORT RunTime steady_now();

/// Seconds as a double, for formulas and reports.
constexpr double to_seconds(Duration d) { return std::chrono::duration<double>(d).count(); }
/// Seconds since the clock's zero.
template <class Clock>
constexpr double to_seconds(std::chrono::time_point<Clock, Duration> t) {
  return to_seconds(t.time_since_epoch());
}

/// Nearest nanosecond to a number of seconds.
constexpr Duration from_seconds(double seconds) {
  return Duration(static_cast<Duration::rep>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5)));
}

/// The wire's microseconds (HIL_SENSOR.time_usec and its echo), rounded down.
constexpr std::uint64_t to_time_usec(SimTime t) {
  return static_cast<std::uint64_t>(t.time_since_epoch().count() / 1000);
}
/// Stamps beyond this (126 years) are damage: as nanoseconds they would soon overflow.
inline constexpr std::uint64_t kLatestTimeUsec = 4'000'000'000'000'000;

/// Inverse of to_time_usec(); later stamps than kLatestTimeUsec count as that, so that differences
/// of received stamps do not overflow.
constexpr SimTime from_time_usec(std::uint64_t usec) {
  return SimTime(Duration(static_cast<Duration::rep>(std::min(usec, kLatestTimeUsec) * 1000)));
}

}  // namespace cas::base
