// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/thrust_setpoint.hpp"

#include <algorithm>
#include <cmath>

namespace cas::fcu {

using Eigen::Vector2d;
using Eigen::Vector3d;

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

  // Height first: the vertical force within the limits, then what tilt and thrust leave.
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
