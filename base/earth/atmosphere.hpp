// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/export.hpp"

namespace cas::base {

/// 0 degC in K, [ISO 2533].
inline constexpr double kZeroCelsius_K = 273.15;

/// Air in hydrostatic balance whose temperature changes evenly with altitude in each layer; the
/// defaults are the International Standard Atmosphere, [ISO 2533]. Below 11 km it is the model of
/// `<atmosphere type="adiabatic">` in SDF 1.10; above, the temperature changes as in the standard
/// layers, up to 80 km. Altitudes in m above mean sea level, taken as geopotential.
///
/// Humidity makes the air lighter; the pressure's fall with altitude is that of dry air.
struct CAS_BASE_EXPORT Atmosphere {
  double temperature_K = 288.15;              ///< at sea level
  double temperature_gradient_K_m = -0.0065;  ///< with rising altitude, up to 11 km
  double pressure_Pa = 101325;                ///< at sea level
  double relative_humidity = 0;               ///< over water, 0..1, at every altitude

  bool operator==(const Atmosphere&) const = default;

  /// Air temperature, K; not below 1 K, wherever the gradient would lead.
  double temperature_kelvin(double alt_m) const;
  /// Static pressure, Pa.
  double pressure_pa(double alt_m) const;
  /// Density, kg/m^3, of air whose share of vapour has the partial pressure e:
  /// (p - (1 - M_v / M_a) e) / (R_a T), an ideal mixture of ideal gases.
  double density_kg_m3(double alt_m) const;
};

/// Pressure of saturated vapour over water, Pa, by [Buck] 1981, Eq. (8), ew1: within 0.1 % from -20
/// to 50 degC.
CAS_BASE_EXPORT double saturation_pressure_pa(double temperature_kelvin);

/// International Standard Atmosphere, [ISO 2533], dry. Altitudes in m above mean sea level, taken
/// as geopotential.
namespace isa {

/// Air temperature, K: 288.15 K at sea level, less 6.5 K per km up to 11 km.
CAS_BASE_EXPORT double temperature_kelvin(double alt_m);
/// Static pressure, Pa: 101 325 Pa at sea level.
CAS_BASE_EXPORT double pressure_pa(double alt_m);
/// Density of dry air, kg/m^3: 1.225 kg/m^3 at sea level.
CAS_BASE_EXPORT double density_kg_m3(double alt_m);
/// Inverse of pressure_pa() in the troposphere (altimeters know no other layer): m above mean sea
/// level, up to 11 km.
CAS_BASE_EXPORT double altitude_m(double pressure_pa);

}  // namespace isa
}  // namespace cas::base
