// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/position_controller.hpp"

#include <cmath>

namespace cas::fcu {
namespace {

Eigen::Vector2d limited(const Eigen::Vector2d& v, double limit) {
  const double length = v.norm();
  return length > limit ? Eigen::Vector2d(v * (limit / length)) : v;
}

Eigen::Vector2d zero_where_unset(const Eigen::Vector3d& v) {
  return {std::isfinite(v.x()) ? v.x() : 0.0, std::isfinite(v.y()) ? v.y() : 0.0};
}

}  // namespace

void PositionController::set_params(const ControlParams& params) {
  p_ = params.xy_p;
  velocity_limit_ = params.xy_velocity_limit_m_s;
  acceleration_limit_ = params.acceleration_limit_m_s2;
  for (Pid& pid : velocity_) pid.set_gains(params.xy_velocity);
}

Eigen::Vector2d PositionController::update(const TrajectorySetpoint& setpoint,
                                           const Eigen::Vector3d& p_N, const Eigen::Vector3d& v_N,
                                           const Eigen::Vector3d& a_N,
                                           const Eigen::Vector2d& saturated_N, double dt) {
  // Position: what it adds to the fed-forward velocity is limited together with it.
  Eigen::Vector2d wanted = zero_where_unset(setpoint.v_N);
  for (int axis = 0; axis < 2; ++axis) {
    if (std::isfinite(setpoint.p_N[axis])) wanted[axis] += p_ * (setpoint.p_N[axis] - p_N[axis]);
  }
  const Eigen::Vector2d velocity_setpoint = limited(wanted, velocity_limit_);

  // Velocity. An axis with neither position nor velocity gets its acceleration only.
  Eigen::Vector2d acceleration = zero_where_unset(setpoint.a_N);
  for (int axis = 0; axis < 2; ++axis) {
    if (!std::isfinite(setpoint.p_N[axis]) && !std::isfinite(setpoint.v_N[axis])) continue;
    const double error = velocity_setpoint[axis] - v_N[axis];
    const bool winding = error * saturated_N[axis] > 0;
    const double rate = a_N[axis] - (std::isfinite(setpoint.a_N[axis]) ? setpoint.a_N[axis] : 0.0);
    acceleration[axis] += velocity_[axis].update(error, rate, dt, {winding, winding});
  }
  return limited(acceleration, acceleration_limit_);
}

}  // namespace cas::fcu
