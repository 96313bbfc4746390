// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "base/config/config.hpp"
#include "base/earth/atmosphere.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "plugins/common/gauss_markov.hpp"

namespace cas::sim {

struct BarometerParams {
  double rate_hz = 0;
  double stddev_pa = 0;  ///< white, one sample
  GaussMarkovParams<1> drift;
  double self_heating_degc = 0;          ///< of the sensor against the air
  double wind_pressure_coefficient = 0;  ///< share of the dynamic pressure that is read
  double lsb_pa = 0;
};

/// Reads the block `barometer`: its keys are those of its sheet (base/config/sensor_sheets.hpp).
BarometerParams parse_barometer_params(const base::ConfigNode& node, double step_s);

/// Static pressure of the world's air with the weather of the day (standard atmosphere, ISO 2533,
/// where neither is given), white noise, drift and the pressure of the airflow on the sensor.
class BarometerModel {
 public:
  BarometerModel() = default;
  BarometerModel(const BarometerParams& params, std::uint64_t seed);

  /// @param alt_m        altitude above mean sea level
  /// @param airspeed_m_s speed through the air
  /// @param air_density_kg_m3  for the dynamic pressure
  /// @param air          pressure and temperature by altitude
  BarometerSample sample(base::SimTime time, double alt_m, double airspeed_m_s,
                         double air_density_kg_m3, const base::Atmosphere& air = {});

  const BarometerParams& params() const { return params_; }

 private:
  BarometerParams params_;
  base::NormalRandom random_;
  GaussMarkov<1> drift_;
};

}  // namespace cas::sim
