// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/config/vehicle.hpp"

namespace cas::sim {

/// Thrust of a propeller that the air meets along its axis, not below 0.
///
/// @param omega_rad_s  its speed
/// @param axial_m_s    of its hub through the air, along its axis
inline double wash_thrust_n(const base::Rotor& rotor, double omega_rad_s, double axial_m_s,
                            double air_density_kg_m3) {
  if (rotor.propeller) {
    return std::max(0.0, rotor.propeller->thrust_n(air_density_kg_m3, omega_rad_s, axial_m_s));
  }
  const base::RotorParams& params = rotor.params;
  const double density =
      params.reference_density_kg_m3 > 0 ? air_density_kg_m3 / params.reference_density_kg_m3 : 1.0;
  const double faded = params.zero_thrust_speed_m_s > 0
                           ? std::clamp(1 - axial_m_s / params.zero_thrust_speed_m_s, 0.0, 1.0)
                           : 1.0;
  return params.thrust_coefficient * omega_rad_s * omega_rad_s * density * faded;
}

/// Speed that a propeller's wash adds at a distance behind its disc, m/s, by momentum theory of an
/// actuator disc: v_i (1 + s / sqrt(s^2 + R^2)), from v_i in the disc to 2 v_i far behind it, with
/// 2 rho A (V + v_i) v_i = T. McCormick, Aerodynamics, Aeronautics and Flight Mechanics, Ch. 6.
///
/// @param axial_m_s  V, of the disc through the air; below 0 counts as 0
/// @param behind_m   s; below 0 ahead of it
inline double wash_m_s(double thrust_n, double axial_m_s, double air_density_kg_m3, double radius_m,
                       double behind_m) {
  if (!(air_density_kg_m3 > 0) || !(radius_m > 0)) return 0;
  const double half = std::max(axial_m_s, 0.0) / 2;
  const double area_m2 = std::numbers::pi * radius_m * radius_m;
  const double induced =
      std::sqrt(half * half + thrust_n / (2 * air_density_kg_m3 * area_m2)) - half;
  return induced * (1 + behind_m / std::hypot(behind_m, radius_m));
}

}  // namespace cas::sim
