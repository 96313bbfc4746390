// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "base/time/clock.hpp"

namespace cas::fcu {

/// How the estimate begins: tilt from gravity and heading from the magnetic field, both averaged
/// while the vehicle is at rest.
class Alignment {
 public:
  /// @param accel_D  specific force, m/s^2
  void on_accelerometer(base::SimTime time, const Eigen::Vector3d& accel_D);
  /// @param field_D  any unit
  void on_magnetometer(const Eigen::Vector3d& field_D);

  /// Enough samples for a heading.
  bool has_heading() const;
  /// The average is long enough. Without a heading (no field, or the place on earth is unknown) the
  /// tilt alone takes longer, so that a compass that starts late is still waited for.
  bool complete(bool heading_usable) const;

  /// Attitude of D in N; the heading is 0 when `with_heading` is not set.
  /// @param earth_field_N  at this place, any unit
  Eigen::Quaterniond attitude(const Eigen::Vector3d& earth_field_N, bool with_heading) const;

 private:
  base::SimTime start_;
  base::SimTime last_;
  int accel_samples_ = 0;
  int mag_samples_ = 0;
  Eigen::Vector3d accel_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d mag_sum_ = Eigen::Vector3d::Zero();
};

/// Attitude with a known tilt and the heading at which `field_D` points along the earth's field.
/// @param roll_rad, pitch_rad  tilt
Eigen::Quaterniond attitude_from_field(double roll_rad, double pitch_rad,
                                       const Eigen::Vector3d& field_D,
                                       const Eigen::Vector3d& earth_field_N);

}  // namespace cas::fcu
