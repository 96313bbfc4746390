// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/airspeed/airspeed_model.hpp"

#include <cmath>

#include "plugins/common/noise_params.hpp"

namespace cas::sim {

double speed_along_tube(const BodyState& body, const Eigen::Vector3d& wind_W,
                        const base::AirspeedSheet& sheet) {
  const Eigen::Vector3d v_WA_B = body.q_WB.conjugate() * (body.v_WB - wind_W);
  return sheet.direction_B.dot(v_WA_B + body.w_WB_B.cross(sheet.position_B_m));
}

AirspeedModel::AirspeedModel(const base::AirspeedSheet& sheet, double step_s, std::uint64_t seed)
    : sheet_(sheet),
      stddev_pa_(white_noise(sheet.noise, 1.0, sheet.rate_hz).x()),
      share_(sheet.lag_s > 0 ? -std::expm1(-step_s / sheet.lag_s) : 1.0),
      random_(seed),
      drift_(drift_of_one(sheet.drift), 1.0 / sheet.rate_hz) {
  drift_.settle(random_);
}

void AirspeedModel::follow(double speed_m_s, double air_density_kg_m3) {
  const double dynamic_pa = 0.5 * air_density_kg_m3 * speed_m_s * std::abs(speed_m_s);
  const double at_tube_pa = (1.0 + sheet_.position_error) * dynamic_pa;
  const double before_pa = pressure_pa_.value_or(at_tube_pa);
  pressure_pa_ = before_pa + share_ * (at_tube_pa - before_pa);
}

AirspeedSample AirspeedModel::sample(base::SimTime time) {
  AirspeedSample sample;
  sample.time = time;
  sample.differential_pressure_pa = pressure_pa_.value_or(0) + sheet_.bias_pa +
                                    drift_.advance(random_)[0] + stddev_pa_ * random_();
  return sample;
}

}  // namespace cas::sim
