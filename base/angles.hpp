// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace cas::base {

/// Factors between degrees and radians, for vectors and for units of keys.
inline constexpr double kRadPerDeg = M_PI / 180.0;
inline constexpr double kDegPerRad = 180.0 / M_PI;

/// One angle. A product with a factor above may differ in the last bit.
constexpr double radians(double degrees) { return degrees * M_PI / 180.0; }
constexpr double degrees(double radians) { return radians * 180.0 / M_PI; }

}  // namespace cas::base
