// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "base/config/aero.hpp"

namespace cas::sim {

/// Angles from `first` to `last` in equal steps, deg; `last` itself if a step ends there.
struct AngleSweep {
  double first_deg = 0;
  double last_deg = 0;
  double step_deg = 1;

  /// @throws base::ConfigError naming `flag`, where the sweep has no or too many angles, or goes
  ///         beyond +-`limit_deg`
  std::vector<double> angles_deg(const std::string& flag, double limit_deg) const;
};

/// What forces and moments are divided by, beside the dynamic pressure.
struct PolarReference {
  double area_m2 = 0;
  double span_m = 0;   ///< of C_l and C_n
  double chord_m = 0;  ///< of C_m

  /// Reference values of the derivatives. A model of panels alone has the area of the panels that
  /// lift upwards, and 1 m for both lengths: its panels stand where the coefficients of many small
  /// models put them, not where a span ends.
  static PolarReference of(const base::AeroParams& aero);
};

/// Measures a vehicle's polar in a virtual wind tunnel: the body of plugin aero stands in steady
/// air at sea level without turning, its surfaces neutral, without rotors.
///
/// @return CSV, a line for each pair of angles: alpha_deg,beta_deg,CL,CD,CY,Cl,Cm,Cn. Lift is up
///         at right angles to the air in the plane of symmetry, drag along it there, CY along the
///         right wing; moments are about the centre of gravity, in the axes of D.
std::string polar_csv(const base::AeroParams& aero, double airspeed_m_s,
                      const std::vector<double>& alphas_deg, const std::vector<double>& betas_deg);

}  // namespace cas::sim
