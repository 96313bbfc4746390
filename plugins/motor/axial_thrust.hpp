// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

namespace cas::sim {

/// Thrust of a rotor of fixed pitch that climbs or descends along its axis, over its thrust in
/// hover at the same speed.
///
/// Blade-element theory: C_T falls linearly with the inflow (Leishman, Principles of Helicopter
/// Aerodynamics, 2nd ed., Sect. 3.2), so that with V the climb over the induced velocity in hover,
/// v_h = sqrt(T_h / (2 rho A)),
///
///   t = T / T_h = 1 - g (V + v_i / v_h - 1),   g = sigma a / (8 lambda_h)
///
/// The induced velocity v_i is that of momentum theory in climb and in the windmill-brake state,
/// and between them, where a vortex ring forms, Leishman's fit to measurements (the same book,
/// Ch. 2, with an induced power factor of 1): v_i / v_h = 1 - 1.125 V - 1.372 V^2 - 1.718 V^3 -
/// 0.655 V^4 for V from -2 to 0. All hold for the rotor's actual thrust t. Forward speed, the
/// unsteadiness of the vortex ring and thrust below zero are not modelled.
class AxialThrust {
 public:
  AxialThrust() = default;
  /// @param slope  g
  explicit AxialThrust(double slope);

  /// t, 0 or more, from a table: to 1e-3, near no thrust to 5e-3.
  /// @param climb  V; beyond +-6 as there
  double share(double climb) const;

  /// v_i over the induced velocity in hover of a rotor with the same thrust.
  static double induced_velocity(double climb);

 private:
  static constexpr double kMost = 6;
  static constexpr std::size_t kPerUnit = 32;
  static constexpr std::size_t kPoints = static_cast<std::size_t>(2 * kMost) * kPerUnit + 1;

  std::array<double, kPoints> table_{};
};

}  // namespace cas::sim
