// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "base/config/sensor_sheets.hpp"
#include "base/earth/atmosphere.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "plugins/common/gauss_markov.hpp"

namespace cas::sim {

/// Static pressure of the world's air with the weather of the day (standard atmosphere, ISO 2533,
/// where neither is given), white noise, drift and the pressure of the airflow on the sensor.
class BarometerModel {
 public:
  BarometerModel() = default;
  BarometerModel(const base::BarometerSheet& sheet, std::uint64_t seed);

  /// @param alt_m        altitude above mean sea level
  /// @param airspeed_m_s speed through the air
  /// @param air_density_kg_m3  for the dynamic pressure
  /// @param air          pressure and temperature by altitude
  BarometerSample sample(base::SimTime time, double alt_m, double airspeed_m_s,
                         double air_density_kg_m3, const base::Atmosphere& air = {});

  const base::BarometerSheet& sheet() const { return sheet_; }

 private:
  base::BarometerSheet sheet_;
  double stddev_pa_ = 0;  ///< white, one sample
  base::NormalRandom random_;
  GaussMarkov<1> drift_;
};

}  // namespace cas::sim
