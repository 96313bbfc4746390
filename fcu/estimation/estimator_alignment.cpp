// SPDX-License-Identifier: BSD-3-Clause
// How the estimate begins: tilt from gravity and heading from the magnetic field, at rest.
#include <cmath>

#include "base/earth/frames.hpp"
#include "fcu/estimation/estimator.hpp"

namespace cas::fcu {
namespace {

using base::to_seconds;
using Eigen::Vector3d;

constexpr double kAlignmentTime_s = 0.5;
constexpr double kAlignmentWithoutMag_s = 2.0;
constexpr double kHeadingUnknown_rad = 1.8;  // uniform over the circle

}  // namespace

void Estimator::align(const ImuInput& imu) {
  if (alignment_.imu_samples == 0) alignment_.start = imu.time;
  ++alignment_.imu_samples;
  alignment_.accel += imu.accel_D;
  alignment_.gyro += imu.gyro_D;
  const double elapsed = to_seconds(imu.time - alignment_.start);
  const bool has_heading = alignment_.mag_samples >= 10 && field_known_;
  if (elapsed >= kAlignmentTime_s && (has_heading || elapsed >= kAlignmentWithoutMag_s)) {
    state_.time = imu.time;
    finish_alignment();
  }
}

void Estimator::finish_alignment() {
  const Vector3d f_D = alignment_.accel / alignment_.imu_samples;
  const double roll = std::atan2(-f_D.y(), -f_D.z());
  const double pitch = std::atan2(f_D.x(), std::hypot(f_D.y(), f_D.z()));
  double yaw = 0;
  heading_aligned_ = alignment_.mag_samples >= 10 && field_known_;
  if (heading_aligned_) {
    const Vector3d level =
        base::quaternion_rpy(roll, pitch, 0) * (alignment_.mag / alignment_.mag_samples);
    yaw = std::atan2(state_.earth_field_N.y(), state_.earth_field_N.x()) -
          std::atan2(level.y(), level.x());
  }
  state_.q_ND = base::quaternion_rpy(roll, pitch, base::wrap_angle(yaw));
  state_.gyro_bias_D.setZero();
  state_.accel_bias_D.setZero();
  start_covariance();
  history_.clear();
  last_walk_ = state_.time;
  aligned_ = true;
}

void Estimator::start_covariance() {
  using C = ErrorCovariance;
  const auto square = [](double x) { return x * x; };
  const double tilt = square(params_.tilt_initial_rad);
  const double heading = square(heading_aligned_ ? params_.tilt_initial_rad : kHeadingUnknown_rad);
  covariance_.set_block(C::kTheta, Vector3d(tilt, tilt, heading));
  covariance_.reset_block(C::kVelocity, 3, square(0.5));
  covariance_.reset_block(C::kPosition, 3, square(params_.gps_position_noise_m));
  covariance_.reset_block(C::kGyroBias, 3, square(params_.gyro_bias_initial_rad_s));
  covariance_.reset_block(C::kAccelBias, 3, square(params_.accel_bias_initial_m_s2));
  covariance_.reset_block(C::kEarthField, 3, square(params_.earth_field_initial_gauss));
  covariance_.reset_block(C::kBodyField, 3, square(params_.body_field_initial_gauss));
  covariance_.reset_block(C::kBaroOffset, 1, square(params_.baro_offset_initial_m));
}

}  // namespace cas::fcu
