// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/earth/geodesy.hpp"
#include "base/export.hpp"

namespace cas::base {

/// Default decimal year: the middle of 2026.
inline constexpr double kUsualYear = 2026.5;

/// Earth's magnetic field in N (north, east, down), gauss, by the World Magnetic Model [WMM2025],
/// degree and order 12. Evaluate it once per kilometre, not per sample.
/// @param decimal_year  2025.0 to 2030.0; clamped to that range
CAS_BASE_EXPORT Eigen::Vector3d magnetic_field_N(const Geodetic& place, double decimal_year);

/// Angle from true to magnetic north, rad, east positive.
CAS_BASE_EXPORT double magnetic_declination(const Geodetic& place, double decimal_year);

}  // namespace cas::base
