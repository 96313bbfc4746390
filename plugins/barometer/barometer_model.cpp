// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/barometer/barometer_model.hpp"

#include <cmath>

#include "base/config/sensor_sheets.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {

BarometerParams parse_barometer_params(const base::ConfigNode& node, double step_s) {
  const base::BarometerSheet sheet = base::read_barometer_sheet(node);
  check_rate(node, sheet.rate_hz, step_s);
  const GaussMarkovParams<3> drift = drift_of(sheet.drift, 1.0);
  return {.rate_hz = sheet.rate_hz,
          .stddev_pa = white_noise(sheet.noise, 1.0, sheet.rate_hz).x(),
          .drift = {drift.walk.head<1>(), drift.time_constant_s},
          .self_heating_degc = sheet.self_heating_degc,
          .wind_pressure_coefficient = sheet.wind_pressure_coefficient,
          .lsb_pa = sheet.lsb_pa};
}

BarometerModel::BarometerModel(const BarometerParams& params, std::uint64_t seed)
    : params_(params), random_(seed), drift_(params.drift, 1.0 / params.rate_hz) {
  drift_.settle(random_);
}

BarometerSample BarometerModel::sample(base::SimTime time, double alt_m, double airspeed_m_s,
                                       double air_density_kg_m3, const base::Atmosphere& air) {
  const double dynamic_pa = 0.5 * air_density_kg_m3 * airspeed_m_s * airspeed_m_s;
  BarometerSample sample;
  sample.time = time;
  sample.pressure_pa = air.pressure_pa(alt_m) + params_.wind_pressure_coefficient * dynamic_pa +
                       drift_.advance(random_)[0] + params_.stddev_pa * random_();
  if (params_.lsb_pa > 0) {
    sample.pressure_pa = std::round(sample.pressure_pa / params_.lsb_pa) * params_.lsb_pa;
  }
  sample.temperature_degc =
      air.temperature_kelvin(alt_m) - base::kZeroCelsius_K + params_.self_heating_degc;
  return sample;
}

}  // namespace cas::sim
