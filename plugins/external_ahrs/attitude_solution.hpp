// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace cas::sim {

/// Attitude from the unit's own sensors: rates integrated, and turned slowly towards the vertical
/// of the accelerometer and the north of the compass (complementary filter, as [Mahony] without
/// the estimate of the gyro's bias). The vertical is not corrected while the specific force
/// differs from gravity by more than a tenth.
class AttitudeSolution {
 public:
  /// @param declination_rad  from true to magnetic north, east positive
  explicit AttitudeSolution(double declination_rad) : declination_rad_(declination_rad) {}

  /// @param accel_D  specific force, m/s^2; gyro_D: rad/s; dt: s since the last sample
  void on_inertial(const Eigen::Vector3d& accel_D, const Eigen::Vector3d& gyro_D, double dt);
  /// Any unit: only the direction counts.
  void on_field(const Eigen::Vector3d& field_D) { field_D_ = field_D; }

  /// Attitude of D in N; the identity before the first samples.
  const Eigen::Quaterniond& q_ND() const { return q_ND_; }

 private:
  void align(const Eigen::Vector3d& accel_D);
  Eigen::Vector3d correction_D(const Eigen::Vector3d& accel_D) const;
  /// Heading error, rad, of the compass.
  double heading_error() const;

  double declination_rad_;
  std::optional<Eigen::Vector3d> field_D_;
  bool aligned_ = false;
  Eigen::Quaterniond q_ND_ = Eigen::Quaterniond::Identity();
};

}  // namespace cas::sim
