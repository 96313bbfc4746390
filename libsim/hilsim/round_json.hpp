// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

/// Numbers for a picture: rounded, so that their texts are short.
namespace cas::sim {

/// The plugin whose beams are drawn, and its topic.
inline constexpr const char* kRangefinder = "rangefinder";

/// To a whole multiple of `unit`, 1 over a whole number.
inline double rounded(double value, double unit) {
  const double whole = std::round(1 / unit);
  return std::round(value * whole) / whole + 0.0;  // no minus zero
}

inline std::vector<double> rounded(const Eigen::Vector3d& v, double unit) {
  return {rounded(v.x(), unit), rounded(v.y(), unit), rounded(v.z(), unit)};
}

/// w, x, y, z.
inline std::vector<double> rounded(const Eigen::Quaterniond& q, double unit) {
  return {rounded(q.w(), unit), rounded(q.x(), unit), rounded(q.y(), unit), rounded(q.z(), unit)};
}

}  // namespace cas::sim
