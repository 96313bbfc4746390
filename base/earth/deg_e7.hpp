// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

namespace cas::base {

/// Latitudes and longitudes as receivers and MAVLink (degE7) send them: in 1e-7 degree, 11 mm.
inline constexpr double kDegE7 = 1e7;

/// The nearest one. @param degrees  -180 to 180
inline std::int32_t deg_e7(double degrees) {
  return static_cast<std::int32_t>(std::lround(degrees * kDegE7));
}

/// Degrees: the nearest number to it.
inline double degrees_of_e7(std::int32_t value) { return value / kDegE7; }

}  // namespace cas::base
