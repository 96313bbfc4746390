// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/external_ahrs/attitude_solution.hpp"

#include <cmath>

#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"

namespace cas::sim {
namespace {

constexpr double kGain_per_s = 0.5;      // of a share of the error that is removed
constexpr double kMostForceError = 0.1;  // of gravity

}  // namespace

void AttitudeSolution::on_inertial(const Eigen::Vector3d& accel_D, const Eigen::Vector3d& gyro_D,
                                   double dt) {
  if (!aligned_) return align(accel_D);
  const Eigen::Vector3d turn_D = (gyro_D + kGain_per_s * correction_D(accel_D)) * dt;
  const double angle = turn_D.norm();
  if (angle <= 0) return;
  q_ND_ = (q_ND_ * Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn_D / angle))).normalized();
}

/// Roll and pitch by the vertical, yaw by the compass.
void AttitudeSolution::align(const Eigen::Vector3d& accel_D) {
  if (!field_D_ || accel_D.norm() <= 0) return;
  const Eigen::Vector3d up_D = accel_D.normalized();  // at rest the specific force points up
  const double roll = std::atan2(-up_D.y(), -up_D.z());
  const double pitch = std::asin(std::clamp(up_D.x(), -1.0, 1.0));
  q_ND_ = base::quaternion_rpy(roll, pitch, 0);
  q_ND_ = Eigen::AngleAxisd(heading_error(), Eigen::Vector3d::UnitZ()) * q_ND_;
  aligned_ = true;
}

double AttitudeSolution::heading_error() const {
  const Eigen::Vector3d field_N = q_ND_ * *field_D_;
  return base::wrap_angle(declination_rad_ - std::atan2(field_N.y(), field_N.x()));
}

Eigen::Vector3d AttitudeSolution::correction_D(const Eigen::Vector3d& accel_D) const {
  const Eigen::Quaterniond q_DN = q_ND_.conjugate();
  Eigen::Vector3d error_D = q_DN * Eigen::Vector3d(0, 0, heading_error());
  const double force_error = accel_D.norm() / base::kStandardGravity_m_s2 - 1;
  if (std::abs(force_error) > kMostForceError) return error_D;
  const Eigen::Vector3d up_D = q_DN * Eigen::Vector3d(0, 0, -1);
  error_D += accel_D.normalized().cross(up_D);
  return error_D;
}

}  // namespace cas::sim
