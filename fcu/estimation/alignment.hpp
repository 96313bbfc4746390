// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "base/time/clock.hpp"

namespace cas::fcu {

/// Whether one inertial sample is that of a vehicle at rest: a rate below 0.15 rad/s, and a
/// specific force within 1 m/s^2 of gravity's magnitude.
/// @param gyro_D   rad/s
/// @param accel_D  specific force, m/s^2
bool indicates_rest(const Eigen::Vector3d& gyro_D, const Eigen::Vector3d& accel_D,
                    double gravity_m_s2);

/// Initial attitude of the estimate: tilt from gravity and heading from the magnetic field, both
/// averaged while the vehicle is at rest. The specific force of a vehicle that falls onto a slope
/// and tips over does not point along gravity, so each sample of motion restarts the averages.
/// After 5 s without rest, on a ship for example, samples of motion are averaged as well.
class Alignment {
 public:
  /// @param accel_D  specific force, m/s^2
  /// @param at_rest  see indicates_rest()
  void on_accelerometer(base::SimTime time, const Eigen::Vector3d& accel_D, bool at_rest);
  /// Counts once the vehicle rests. @param field_D  any unit
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
  void begin_anew();

  std::optional<base::SimTime> first_;  // time of the first sample
  base::SimTime start_;                 // time of the first sample in the averages
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
