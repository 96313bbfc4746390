// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

namespace cas::sim {

/// GPS time, ns since 6 January 1980, of a decimal year (2026.5: the middle of 2026, UTC). GPS time
/// is ahead of UTC by 18 leap seconds since 2017 [IERS Bulletin C].
inline std::uint64_t gps_time_ns(double decimal_year) {
  using std::chrono::January;
  using std::chrono::nanoseconds;
  using std::chrono::sys_days;
  const int whole = static_cast<int>(std::floor(decimal_year));
  const sys_days begin = std::chrono::year(whole) / January / 1;
  const sys_days end = std::chrono::year(whole + 1) / January / 1;
  const sys_days gps_begin = std::chrono::year(1980) / January / 6;
  constexpr nanoseconds kLeap = std::chrono::seconds(18);
  const double year_ns = static_cast<double>(nanoseconds(end - begin).count());
  const auto into_year = static_cast<std::int64_t>((decimal_year - whole) * year_ns);
  return static_cast<std::uint64_t>((nanoseconds(begin - gps_begin) + kLeap).count() + into_year);
}

}  // namespace cas::sim
