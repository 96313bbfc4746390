// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/altitude_controller.hpp"

#include <algorithm>
#include <cmath>

namespace cas::fcu {

void AltitudeController::set_params(const ControlParams& params) {
  p_ = params.z_p;
  up_limit_ = params.z_velocity_up_limit_m_s;
  down_limit_ = params.z_velocity_down_limit_m_s;
  velocity_.set_gains(params.z_velocity);
}

double AltitudeController::update(const TrajectorySetpoint& setpoint, double z, double vz,
                                  double az, Saturation saturation, double dt) {
  const double feed_forward = std::isfinite(setpoint.a_N.z()) ? setpoint.a_N.z() : 0.0;
  const bool has_position = std::isfinite(setpoint.p_N.z());
  const bool has_velocity = std::isfinite(setpoint.v_N.z());
  if (!has_position && !has_velocity) return feed_forward;

  double velocity = has_velocity ? setpoint.v_N.z() : 0.0;
  if (has_position) velocity += p_ * (setpoint.p_N.z() - z);
  velocity = std::clamp(velocity, -up_limit_, down_limit_);
  return feed_forward + velocity_.update(velocity - vz, az - feed_forward, dt, saturation);
}

}  // namespace cas::fcu
