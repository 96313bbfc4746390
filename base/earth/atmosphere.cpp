// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/atmosphere.hpp"

#include <cmath>

namespace cas::base::isa {
namespace {

// ISO 2533:1975, table of primary constants; troposphere, up to 11 km.
constexpr double kSeaLevelTemperature = 288.15;                               // K
constexpr double kSeaLevelPressure = 101325.0;                                // Pa
constexpr double kLapseRate = 0.0065;                                         // K/m
constexpr double kGasConstant = 287.05287;                                    // J/(kg K), dry air
constexpr double kStandardGravity = 9.80665;                                  // m/s^2
constexpr double kExponent = kStandardGravity / (kGasConstant * kLapseRate);  // 5.25588

}  // namespace

double temperature_kelvin(double alt_m) { return kSeaLevelTemperature - kLapseRate * alt_m; }

double pressure_pa(double alt_m) {
  return kSeaLevelPressure * std::pow(temperature_kelvin(alt_m) / kSeaLevelTemperature, kExponent);
}

double density_kg_m3(double alt_m) {
  return pressure_pa(alt_m) / (kGasConstant * temperature_kelvin(alt_m));
}

double altitude_m(double pressure_pa) {
  const double ratio = std::pow(pressure_pa / kSeaLevelPressure, 1.0 / kExponent);
  return kSeaLevelTemperature / kLapseRate * (1.0 - ratio);
}

}  // namespace cas::base::isa
