// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/export.hpp"

/// International Standard Atmosphere (ISO 2533), troposphere. Altitudes in metres above mean sea
/// level.
namespace cas::base::isa {

CAS_BASE_EXPORT double temperature_kelvin(double alt_m);
CAS_BASE_EXPORT double pressure_pa(double alt_m);
CAS_BASE_EXPORT double density_kg_m3(double alt_m);
/// Inverse of pressure_pa.
CAS_BASE_EXPORT double altitude_m(double pressure_pa);

}  // namespace cas::base::isa
