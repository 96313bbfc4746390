// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/attitude_controller.hpp"

#include <algorithm>
#include <cmath>

namespace cas::fcu {

using Eigen::Quaterniond;
using Eigen::Vector3d;

void AttitudeController::set_params(const ControlParams& params) {
  yaw_weight_ = std::clamp(params.yaw_weight, 0.05, 1.0);
  // The weight shrinks the heading error; the gain makes up for it.
  gain_ = Vector3d(params.roll_p, params.pitch_p, params.yaw_p / yaw_weight_);
  rate_limit_ = params.rate_limit_rad_s;
}

Vector3d AttitudeController::update(const AttitudeSetpoint& setpoint, const Quaterniond& q_ND,
                                    double turn_limit_rad_s) const {
  // Tilt only: the shortest rotation that brings Dz onto the wanted Dz.
  const Vector3d z_now = q_ND * Vector3d::UnitZ();
  const Vector3d z_wanted = setpoint.q_ND * Vector3d::UnitZ();
  const Quaterniond q_tilt_N = Quaterniond::FromTwoVectors(z_now, z_wanted);
  const Quaterniond q_reduced = q_tilt_N * q_ND;
  if (turn_limit_rad_s <= 0) {
    const Quaterniond q_tilt = q_ND.inverse() * q_reduced;
    Vector3d rates = 2 * gain_.cwiseProduct(q_tilt.vec());
    rates.z() = 0;
    return rates.cwiseMax(-rate_limit_).cwiseMin(rate_limit_);
  }

  // The rest is a turn about Dz; a part of it is demanded at once.
  Quaterniond q_turn = q_reduced.inverse() * setpoint.q_ND;
  if (q_turn.w() < 0) q_turn.coeffs() = -q_turn.coeffs();
  const double half_turn = std::atan2(q_turn.z(), q_turn.w());
  const Quaterniond q_part(Eigen::AngleAxisd(2 * half_turn * yaw_weight_, Vector3d::UnitZ()));
  Quaterniond q_error = q_ND.inverse() * (q_reduced * q_part);
  if (q_error.w() < 0) q_error.coeffs() = -q_error.coeffs();

  Vector3d rates = 2 * gain_.cwiseProduct(q_error.vec()) +
                   q_ND.inverse() * Vector3d(0, 0, setpoint.yaw_rate_rad_s);
  rates.z() = std::clamp(rates.z(), -turn_limit_rad_s, turn_limit_rad_s);
  return rates.cwiseMax(-rate_limit_).cwiseMin(rate_limit_);
}

}  // namespace cas::fcu
