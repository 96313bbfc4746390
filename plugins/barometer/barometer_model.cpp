// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/barometer/barometer_model.hpp"

#include <cmath>

#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

constexpr double kStandardQnh = 1013.25;  // hPa, ISO 2533
constexpr double kZeroCelsius = 273.15;   // K

GaussMarkovParams<1> parse_pressure_drift(const base::ConfigNode& node) {
  const GaussMarkovParams<3> axes = parse_drift(node, {"", "pa", 1.0});
  return {axes.walk.head<1>(), axes.time_constant_s};
}

}  // namespace

BarometerParams parse_barometer_params(const base::ConfigNode& node, double step_s) {
  BarometerParams params;
  params.rate_hz = parse_rate(node, step_s);
  params.stddev_pa = parse_white_noise(node, {"", "pa", 1.0}, params.rate_hz).x();
  params.drift = parse_pressure_drift(node);
  params.qnh_hpa = node.get_in("qnh_hpa", kStandardQnh, 850.0, 1100.0);
  params.temperature_offset_degc = node.get_in("temperature_offset_degc", 0.0, -80.0, 80.0);
  params.self_heating_degc = node.get_in("self_heating_degc", 0.0, -50.0, 100.0);
  params.wind_pressure_coefficient = node.get_in("wind_pressure_coefficient", 0.0, -2.0, 2.0);
  params.lsb_pa = node.get_in("lsb_pa", 0.0, 0.0, 1000.0);
  return params;
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
  sample.pressure_pa = air.pressure_pa(alt_m) * (params_.qnh_hpa / kStandardQnh) +
                       params_.wind_pressure_coefficient * dynamic_pa + drift_.advance(random_)[0] +
                       params_.stddev_pa * random_();
  if (params_.lsb_pa > 0) {
    sample.pressure_pa = std::round(sample.pressure_pa / params_.lsb_pa) * params_.lsb_pa;
  }
  sample.temperature_degc = air.temperature_kelvin(alt_m) - kZeroCelsius +
                            params_.temperature_offset_degc + params_.self_heating_degc;
  return sample;
}

}  // namespace cas::sim
