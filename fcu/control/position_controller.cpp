// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/position_controller.hpp"

#include <algorithm>
#include <cmath>

namespace cas::fcu {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Horizontal.

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
  // Position: its share and the fed-forward velocity are limited together.
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

// Vertical.

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

// From an acceleration to attitude and thrust.

Eigen::Quaterniond attitude_from_direction(const Vector3d& up_N, double yaw) {
  Vector3d z_D = -up_N;
  if (z_D.squaredNorm() < 1e-12) z_D = Vector3d::UnitZ();
  z_D.normalize();
  const Vector3d right_of_heading(-std::sin(yaw), std::cos(yaw), 0);
  Vector3d x_D = right_of_heading.cross(z_D);
  if (z_D.z() < 0) x_D = -x_D;  // inverted: keep the heading
  if (std::abs(z_D.z()) < 1e-6) x_D = Vector3d::UnitZ();
  x_D.normalize();
  Eigen::Matrix3d R_ND;
  R_ND.col(0) = x_D;
  R_ND.col(1) = z_D.cross(x_D).normalized();
  R_ND.col(2) = z_D;
  return Eigen::Quaterniond(R_ND);
}

ThrustSetpoint thrust_for_acceleration(const Vector3d& a_N, double mass_kg, double gravity,
                                       double yaw, const ThrustLimits& limits) {
  ThrustSetpoint result;
  const double up_wanted = mass_kg * (gravity - a_N.z());
  const Vector2d side_wanted = mass_kg * a_N.head<2>();

  // Height first: the vertical force within the limits, then the horizontal force that tilt and
  // thrust allow.
  const double up = std::clamp(up_wanted, limits.min_n, limits.max_n);
  result.thrust_at_max = up_wanted > limits.max_n;
  result.thrust_at_min = up_wanted < limits.min_n;
  const double by_tilt = up * std::tan(limits.tilt_rad);
  const double by_thrust = std::sqrt(std::max(0.0, limits.max_n * limits.max_n - up * up));
  const double side_limit = std::min(by_tilt, by_thrust);
  const double side_length = side_wanted.norm();
  Vector2d side = side_wanted;
  if (side_length > side_limit) side *= side_limit / side_length;
  result.cut_N = side_wanted - side;

  const Vector3d force(side.x(), side.y(), -up);
  result.attitude.q_ND = attitude_from_direction(force, yaw);
  result.attitude.thrust_n = force.norm();
  return result;
}

}  // namespace cas::fcu
