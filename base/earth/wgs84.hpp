// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The ellipsoid of WGS 84 (NIMA TR8350.2, table 3.1).
namespace cas::base::wgs84 {

inline constexpr double kSemiMajor_m = 6'378'137.0;
inline constexpr double kFlattening = 1.0 / 298.257223563;
inline constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);  ///< squared

}  // namespace cas::base::wgs84
