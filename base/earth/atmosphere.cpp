// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/atmosphere.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/gravity.hpp"

namespace cas::base {
namespace {

// ISO 2533:1975, table of primary constants.
constexpr double kGasConstant = 287.05287;  // J/(kg K), dry air

/// A gradient of less is none: over 10 km it makes less than a thousandth of a kelvin.
constexpr double kLeastGradient_K_m = 1e-7;
constexpr double kLeastTemperature_K = 1;

}  // namespace

double Atmosphere::temperature_kelvin(double alt_m) const {
  return std::max(temperature_K + temperature_gradient_K_m * alt_m, kLeastTemperature_K);
}

double Atmosphere::pressure_pa(double alt_m) const {
  if (std::abs(temperature_gradient_K_m) < kLeastGradient_K_m) {
    return pressure_Pa * std::exp(-kStandardGravity_m_s2 * alt_m / (kGasConstant * temperature_K));
  }
  const double exponent = kStandardGravity_m_s2 / (kGasConstant * -temperature_gradient_K_m);
  return pressure_Pa * std::pow(temperature_kelvin(alt_m) / temperature_K, exponent);
}

double Atmosphere::density_kg_m3(double alt_m) const {
  return pressure_pa(alt_m) / (kGasConstant * temperature_kelvin(alt_m));
}

namespace isa {

double temperature_kelvin(double alt_m) { return Atmosphere().temperature_kelvin(alt_m); }

double pressure_pa(double alt_m) { return Atmosphere().pressure_pa(alt_m); }

double density_kg_m3(double alt_m) { return Atmosphere().density_kg_m3(alt_m); }

double altitude_m(double pressure_pa) {
  constexpr Atmosphere kStandard;
  const double exponent =
      kStandardGravity_m_s2 / (kGasConstant * -kStandard.temperature_gradient_K_m);
  const double ratio = std::pow(pressure_pa / kStandard.pressure_Pa, 1.0 / exponent);
  return kStandard.temperature_K / -kStandard.temperature_gradient_K_m * (1.0 - ratio);
}

}  // namespace isa
}  // namespace cas::base
