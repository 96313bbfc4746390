// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/alignment.hpp"

#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::fcu {

using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

// Chosen from the figures of [HILS] Table 1. 250 samples of 0.07 m/s^2 leave 0.5 mrad of tilt, 10
// of 4 mG leave 6 mrad of heading in a horizontal field of 0.2 gauss: well below what the filter
// takes an attitude to be uncertain by (EstimatorParams::tilt_initial_rad).
constexpr double kShortest_s = 0.5;
constexpr int kMagSamples = 10;
// Within this time a receiver of 1 Hz sends the fix that gives the declination.
constexpr double kWithoutHeading_s = 2.0;
constexpr double kPatience_s = 5.0;       // after it, samples of motion are averaged, too
constexpr double kRestRate_rad_s = 0.15;  // larger rates are not rest
constexpr double kRestForce_m_s2 = 1.0;   // larger deviations from gravity are not rest

}  // namespace

bool indicates_rest(const Vector3d& gyro_D, const Vector3d& accel_D, double gravity_m_s2) {
  return gyro_D.norm() < kRestRate_rad_s &&
         std::abs(accel_D.norm() - gravity_m_s2) < kRestForce_m_s2;
}

void Alignment::begin_anew() {
  accel_samples_ = 0;
  mag_samples_ = 0;
  accel_sum_.setZero();
  mag_sum_.setZero();
}

void Alignment::on_accelerometer(base::SimTime time, const Vector3d& accel_D, bool at_rest) {
  if (!first_) first_ = time;
  if (!at_rest && base::to_seconds(time - *first_) < kPatience_s) return begin_anew();
  if (accel_samples_ == 0) start_ = time;
  last_ = time;
  ++accel_samples_;
  accel_sum_ += accel_D;
}

void Alignment::on_magnetometer(const Vector3d& field_D) {
  if (accel_samples_ == 0) return;  // the vehicle still moves
  ++mag_samples_;
  mag_sum_ += field_D;
}

bool Alignment::has_heading() const { return mag_samples_ >= kMagSamples; }

bool Alignment::complete(bool heading_usable) const {
  if (accel_samples_ == 0) return false;
  return base::to_seconds(last_ - start_) >= (heading_usable ? kShortest_s : kWithoutHeading_s);
}

Quaterniond Alignment::attitude(const Vector3d& earth_field_N, bool with_heading) const {
  const Vector3d f_D = accel_sum_ / accel_samples_;
  const double roll = std::atan2(-f_D.y(), -f_D.z());
  const double pitch = std::atan2(f_D.x(), std::hypot(f_D.y(), f_D.z()));
  if (!with_heading) return base::quaternion_rpy(roll, pitch, 0);
  return attitude_from_field(roll, pitch, mag_sum_ / mag_samples_, earth_field_N);
}

Quaterniond attitude_from_field(double roll_rad, double pitch_rad, const Vector3d& field_D,
                                const Vector3d& earth_field_N) {
  const Vector3d level = base::quaternion_rpy(roll_rad, pitch_rad, 0) * field_D;
  const double yaw =
      std::atan2(earth_field_N.y(), earth_field_N.x()) - std::atan2(level.y(), level.x());
  return base::quaternion_rpy(roll_rad, pitch_rad, base::wrap_angle(yaw));
}

}  // namespace cas::fcu
