// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace cas::fcu {

// Values in the units that MAVLink fields have.

inline float to_float(double value) { return static_cast<float>(value); }

inline std::int16_t centi(double value) {
  return static_cast<std::int16_t>(std::clamp(100 * value, -32767.0, 32767.0));
}

inline std::int32_t milli(double value) {
  return static_cast<std::int32_t>(std::lround(1000 * value));
}

inline std::int32_t deg_e7(double degrees) {
  return static_cast<std::int32_t>(std::llround(1e7 * degrees));
}

/// Hundredths of a degree from north, 0 to 35999.
inline std::uint16_t heading_cdeg(double yaw_rad) {
  const double degrees = std::fmod(yaw_rad * 180 / M_PI + 360, 360);
  return static_cast<std::uint16_t>(std::lround(degrees * 100) % 36000);
}

}  // namespace cas::fcu
