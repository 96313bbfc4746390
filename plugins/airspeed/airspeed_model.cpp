// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/airspeed/airspeed_model.hpp"

#include <cmath>

#include "base/config/sensor_sheets.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {

AirspeedParams parse_airspeed_params(const base::ConfigNode& node, double step_s) {
  const base::AirspeedSheet sheet = base::read_airspeed_sheet(node);
  check_rate(node, sheet.rate_hz, step_s);
  const GaussMarkovParams<3> drift = drift_of(sheet.drift, 1.0);
  return {.rate_hz = sheet.rate_hz,
          .stddev_pa = white_noise(sheet.noise, 1.0, sheet.rate_hz).x(),
          .bias_pa = sheet.bias_pa,
          .drift = {drift.walk.head<1>(), drift.time_constant_s},
          .position_error = sheet.position_error,
          .lag_s = sheet.lag_s,
          .position_B_m = sheet.position_B_m,
          .direction_B = sheet.direction_B};
}

double speed_along_tube(const BodyState& body, const Eigen::Vector3d& wind_W,
                        const AirspeedParams& params) {
  const Eigen::Vector3d v_WA_B = body.q_WB.conjugate() * (body.v_WB - wind_W);
  return params.direction_B.dot(v_WA_B + body.w_WB_B.cross(params.position_B_m));
}

AirspeedModel::AirspeedModel(const AirspeedParams& params, double step_s, std::uint64_t seed)
    : params_(params),
      share_(params.lag_s > 0 ? -std::expm1(-step_s / params.lag_s) : 1.0),
      random_(seed),
      drift_(params.drift, 1.0 / params.rate_hz) {
  drift_.settle(random_);
}

void AirspeedModel::follow(double speed_m_s, double air_density_kg_m3) {
  const double dynamic_pa = 0.5 * air_density_kg_m3 * speed_m_s * std::abs(speed_m_s);
  const double at_tube_pa = (1.0 + params_.position_error) * dynamic_pa;
  const double before_pa = pressure_pa_.value_or(at_tube_pa);
  pressure_pa_ = before_pa + share_ * (at_tube_pa - before_pa);
}

AirspeedSample AirspeedModel::sample(base::SimTime time) {
  AirspeedSample sample;
  sample.time = time;
  sample.differential_pressure_pa = pressure_pa_.value_or(0) + params_.bias_pa +
                                    drift_.advance(random_)[0] + params_.stddev_pa * random_();
  return sample;
}

}  // namespace cas::sim
