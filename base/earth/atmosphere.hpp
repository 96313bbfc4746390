// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/export.hpp"

namespace cas::base {

/// Dry air in hydrostatic balance whose temperature changes evenly with altitude; the defaults are
/// the International Standard Atmosphere's troposphere, [ISO 2533]. This is the model of
/// `<atmosphere type="adiabatic">` in SDF 1.10. Altitudes in m above mean sea level, taken as
/// geopotential; the standard one is not valid above 11 km. Humidity is not modelled.
struct CAS_BASE_EXPORT Atmosphere {
  double temperature_K = 288.15;              ///< at sea level
  double temperature_gradient_K_m = -0.0065;  ///< with rising altitude
  double pressure_Pa = 101325;                ///< at sea level

  /// Air temperature, K; not below 1 K, wherever the gradient would lead.
  double temperature_kelvin(double alt_m) const;
  /// Static pressure, Pa.
  double pressure_pa(double alt_m) const;
  /// Density, kg/m^3.
  double density_kg_m3(double alt_m) const;
};

/// International Standard Atmosphere, troposphere, [ISO 2533]. Altitudes in m above mean sea level,
/// taken as geopotential; not valid above 11 km.
namespace isa {

/// Air temperature, K: 288.15 K at sea level, less 6.5 K per km.
CAS_BASE_EXPORT double temperature_kelvin(double alt_m);
/// Static pressure, Pa: 101 325 Pa at sea level.
CAS_BASE_EXPORT double pressure_pa(double alt_m);
/// Density of dry air, kg/m^3: 1.225 kg/m^3 at sea level.
CAS_BASE_EXPORT double density_kg_m3(double alt_m);
/// Inverse of pressure_pa(): m above mean sea level.
CAS_BASE_EXPORT double altitude_m(double pressure_pa);

}  // namespace isa
}  // namespace cas::base
