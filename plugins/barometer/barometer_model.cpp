// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/barometer/barometer_model.hpp"

#include <cmath>

#include "plugins/common/noise_params.hpp"

namespace cas::sim {

BarometerModel::BarometerModel(const base::BarometerSheet& sheet, std::uint64_t seed)
    : sheet_(sheet),
      stddev_pa_(white_noise(sheet.noise, 1.0, sheet.rate_hz).x()),
      random_(seed),
      drift_(drift_of_one(sheet.drift), 1.0 / sheet.rate_hz) {
  drift_.settle(random_);
}

BarometerSample BarometerModel::sample(base::SimTime time, double alt_m, double airspeed_m_s,
                                       double air_density_kg_m3, const base::Atmosphere& air) {
  const double dynamic_pa = 0.5 * air_density_kg_m3 * airspeed_m_s * airspeed_m_s;
  BarometerSample sample;
  sample.time = time;
  sample.pressure_pa = air.pressure_pa(alt_m) + sheet_.wind_pressure_coefficient * dynamic_pa +
                       drift_.advance(random_)[0] + stddev_pa_ * random_();
  if (sheet_.lsb_pa > 0) {
    sample.pressure_pa = std::round(sample.pressure_pa / sheet_.lsb_pa) * sheet_.lsb_pa;
  }
  sample.temperature_degc =
      air.temperature_kelvin(alt_m) - base::kZeroCelsius_K + sheet_.self_heating_degc;
  return sample;
}

}  // namespace cas::sim
