// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/angles.hpp"
#include "base/earth/deg_e7.hpp"

namespace cas::fcu {

// Values in the units that MAVLink fields have. A field of whole numbers cannot say that something
// is not a number: that counts as 0.

/// For fields that may hold NaN.
inline float to_float(double value) { return static_cast<float>(value); }

inline void put(const Eigen::Vector3d& v, float& x, float& y, float& z) {
  x = to_float(v.x());
  y = to_float(v.y());
  z = to_float(v.z());
}

/// The nearest whole number that the field can hold; 0 for NaN.
template <class Integer>
Integer to_whole(double value) {
  constexpr double kLow = std::numeric_limits<Integer>::min();
  constexpr double kHigh = std::numeric_limits<Integer>::max();
  return std::isnan(value) ? Integer{0}
                           : static_cast<Integer>(std::clamp(std::round(value), kLow, kHigh));
}

/// Three fields of a message.
inline Eigen::Vector3d vec(float x, float y, float z) {
  return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

/// Hundredths (m/s to cm/s, A to cA, deg C to cdegC), rounded towards zero, within -32767..32767.
inline std::int16_t centi(double value) {
  return std::isnan(value) ? std::int16_t{0}
                           : static_cast<std::int16_t>(std::clamp(100 * value, -32767.0, 32767.0));
}

/// Thousandths (m to mm).
inline std::int32_t milli(double value) { return to_whole<std::int32_t>(1000 * value); }

/// 1e-7 degrees.
inline std::int32_t deg_e7(double degrees) {
  return to_whole<std::int32_t>(base::kDegE7 * degrees);
}

/// Hundredths of a degree from north, 0 to 35999; 0 for a non-finite angle.
inline std::uint16_t heading_cdeg(double yaw_rad) {
  const double degrees = std::fmod(base::degrees(yaw_rad) + 360, 360);
  return static_cast<std::uint16_t>(to_whole<std::uint16_t>(degrees * 100) % 36000);
}

/// A control or motor output within low..high; 0, no drive, for NaN.
inline float output(double value, double low, double high) {
  return std::isnan(value) ? 0.0F : static_cast<float>(std::clamp(value, low, high));
}

}  // namespace cas::fcu
