// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/atmosphere.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/earth/gravity.hpp"

namespace cas::base {
namespace {

// ISO 2533:1975, table of primary constants.
constexpr double kGasConstant = 287.05287;  // J/(kg K), dry air

constexpr double kVapourToAir = 18.01528 / 28.964420;  // molar masses, g/mol; of air [ISO 2533]
// Colder air is practically dry; the formula of [Buck] has a pole at -240.97 degC.
constexpr double kColdestVapour_degc = -100;

/// Layers above the troposphere, [ISO 2533].
struct Layer {
  double bottom_m;
  double top_m;
  double gradient_K_m;
};
constexpr double kTropopause_m = 11'000;
constexpr std::array<Layer, 6> kLayersAbove{{{kTropopause_m, 20'000, 0},
                                             {20'000, 32'000, 0.001},
                                             {32'000, 47'000, 0.0028},
                                             {47'000, 51'000, 0},
                                             {51'000, 71'000, -0.0028},
                                             {71'000, 80'000, -0.002}}};

/// Smaller gradients count as zero: over 10 km they make less than a thousandth of a kelvin.
constexpr double kLeastGradient_K_m = 1e-7;
constexpr double kLeastTemperature_K = 1;

/// Pressure at the top of a layer of constant gradient over that at its bottom, [ISO 2533].
double pressure_ratio(double bottom_K, double top_K, double gradient_K_m, double height_m) {
  if (std::abs(gradient_K_m) < kLeastGradient_K_m) {
    return std::exp(-kStandardGravity_m_s2 * height_m / (kGasConstant * bottom_K));
  }
  return std::pow(top_K / bottom_K, kStandardGravity_m_s2 / (kGasConstant * -gradient_K_m));
}

}  // namespace

double Atmosphere::temperature_kelvin(double alt_m) const {
  const double within = std::min(alt_m, kTropopause_m);
  double kelvin = std::max(temperature_K + temperature_gradient_K_m * within, kLeastTemperature_K);
  for (const Layer& layer : kLayersAbove) {
    if (alt_m <= layer.bottom_m) break;
    const double rise = std::min(alt_m, layer.top_m) - layer.bottom_m;
    kelvin = std::max(kelvin + layer.gradient_K_m * rise, kLeastTemperature_K);
  }
  return kelvin;
}

double Atmosphere::pressure_pa(double alt_m) const {
  const double within = std::min(alt_m, kTropopause_m);
  double pa = pressure_Pa * pressure_ratio(temperature_K, temperature_kelvin(within),
                                           temperature_gradient_K_m, within);
  for (const Layer& layer : kLayersAbove) {
    if (alt_m <= layer.bottom_m) break;
    const double top = std::min(alt_m, layer.top_m);
    pa *= pressure_ratio(temperature_kelvin(layer.bottom_m), temperature_kelvin(top),
                         layer.gradient_K_m, top - layer.bottom_m);
  }
  return pa;
}

double Atmosphere::density_kg_m3(double alt_m) const {
  const double kelvin = temperature_kelvin(alt_m);
  double pa = pressure_pa(alt_m);
  if (relative_humidity > 0) {
    const double vapour_pa = std::min(pa, relative_humidity * saturation_pressure_pa(kelvin));
    pa -= (1 - kVapourToAir) * vapour_pa;
  }
  return pa / (kGasConstant * kelvin);
}

double saturation_pressure_pa(double temperature_kelvin) {
  const double degc = std::max(temperature_kelvin - kZeroCelsius_K, kColdestVapour_degc);
  return 611.21 * std::exp(17.502 * degc / (240.97 + degc));
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
