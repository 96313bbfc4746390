// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/motor/axial_thrust.hpp"

#include <algorithm>
#include <cmath>

namespace cas::sim {
namespace {

/// t that satisfies t = 1 - g (V + v_i / v_h - 1); the right side falls with t.
double solve(double slope, double climb) {
  if (1 - slope * (climb - 1) <= 0) return 0;  // without thrust nothing is induced
  double low = 0;
  double high = std::max(1.0, 1 + slope * (1 - climb));  // without any induced velocity
  constexpr int kHalvings = 50;
  for (int i = 0; i < kHalvings; ++i) {
    const double t = 0.5 * (low + high);
    const double root = std::sqrt(t);
    const double induced = root > 0 ? root * AxialThrust::induced_velocity(climb / root) : 0.0;
    (1 - slope * (climb + induced - 1) > t ? low : high) = t;
  }
  return 0.5 * (low + high);
}

}  // namespace

double AxialThrust::induced_velocity(double climb) {
  if (climb >= 0) return -climb / 2 + std::sqrt(climb * climb / 4 + 1);
  const double fit = 1 + climb * (-1.125 + climb * (-1.372 + climb * (-1.718 + climb * -0.655)));
  if (climb > -2) return fit;
  // The fit meets momentum theory at -2.04.
  return std::max(fit, -climb / 2 - std::sqrt(climb * climb / 4 - 1));
}

AxialThrust::AxialThrust(double slope) {
  for (std::size_t i = 0; i < kPoints; ++i) {
    table_[i] = solve(slope, static_cast<double>(i) / kPerUnit - kMost);
  }
}

double AxialThrust::share(double climb) const {
  const double at = (std::clamp(climb, -kMost, kMost) + kMost) * kPerUnit;
  const auto below = std::min(static_cast<std::size_t>(at), kPoints - 2);
  const double part = at - static_cast<double>(below);
  return table_[below] + part * (table_[below + 1] - table_[below]);
}

}  // namespace cas::sim
