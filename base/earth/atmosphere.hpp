// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/export.hpp"

/// International Standard Atmosphere, troposphere, [ISO 2533]. Altitudes in m above mean sea level,
/// taken as geopotential; not valid above 11 km.
namespace cas::base::isa {

/// Air temperature, K: 288.15 K at sea level, less 6.5 K per km.
CAS_BASE_EXPORT double temperature_kelvin(double alt_m);
/// Static pressure, Pa: 101 325 Pa at sea level.
CAS_BASE_EXPORT double pressure_pa(double alt_m);
/// Density of dry air, kg/m^3: 1.225 kg/m^3 at sea level.
CAS_BASE_EXPORT double density_kg_m3(double alt_m);
/// Inverse of pressure_pa(): m above mean sea level.
CAS_BASE_EXPORT double altitude_m(double pressure_pa);

}  // namespace cas::base::isa
