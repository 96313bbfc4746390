// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/weather.hpp"

namespace cas::base {

namespace {

constexpr double kPascalsOfHpa = 100;

}  // namespace

Atmosphere air_of(const Weather& weather, const Atmosphere& world, double home_alt_m) {
  Atmosphere air = world;
  if (weather.temperature_degc) {
    air.temperature_K +=
        *weather.temperature_degc + kZeroCelsius_K - world.temperature_kelvin(home_alt_m);
  }
  if (weather.temperature_offset_degc) air.temperature_K += *weather.temperature_offset_degc;
  // The measured pressure is that at home; from there it follows the weight of the changed air.
  const double home_pa = weather.qnh_hpa
                             ? *weather.qnh_hpa * kPascalsOfHpa * isa::pressure_pa(home_alt_m) /
                                   Atmosphere().pressure_Pa
                             : world.pressure_pa(home_alt_m);
  if (air != world || weather.qnh_hpa) air.pressure_Pa *= home_pa / air.pressure_pa(home_alt_m);
  if (weather.humidity) air.relative_humidity = *weather.humidity;
  return air;
}

}  // namespace cas::base
