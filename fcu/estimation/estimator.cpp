// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/estimator.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/atmosphere.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/magnetic_field.hpp"

namespace cas::fcu {
namespace {

using base::to_seconds;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kLongestStep_s = 0.1;       // a longer gap in the samples is not integrated
constexpr double kFusionTimeout_s = 5.0;     // dead reckoning is trusted this long
constexpr double kRejectionTimeout_s = 4.0;  // then the fixes are believed again
constexpr double kRestRate_rad_s = 0.15;     // larger rates are not rest
constexpr double kRestForce_m_s2 = 1.0;      // larger deviations from gravity are not rest
constexpr int kRestSamples = 10;             // IMU samples per rest measurement
constexpr double kRestVelocity_m_s = 0.01;
constexpr double kFlightForce_g = 2.5;       // specific force of the hardest manoeuvre
constexpr double kVelocityUsable_m_s = 1.0;  // larger deviations: no velocity
constexpr double kPositionUsable_m = 10.0;   // larger deviations: no position

/// Rotation vector to quaternion.
Quaterniond exp_map(const Vector3d& theta) {
  const double angle = theta.norm();
  if (angle < 1e-12) return Quaterniond(1, 0.5 * theta.x(), 0.5 * theta.y(), 0.5 * theta.z());
  return Quaterniond(Eigen::AngleAxisd(angle, theta / angle));
}

}  // namespace

Estimator::Estimator(const EstimatorParams& params, double decimal_year)
    : params_(params), decimal_year_(decimal_year) {}

void Estimator::set_origin(const base::Geodetic& origin) {
  projection_ = base::LocalProjection(origin);
  origin_given_ = true;
  set_field_from_model(origin);
}

void Estimator::set_field_from_model(const base::Geodetic& place) {
  state_.earth_field_N = base::magnetic_field_N(place, decimal_year_);
  field_known_ = true;
}

// Prediction.

void Estimator::on_imu(const ImuInput& imu) {
  if (!imu.gyro_D.allFinite() || !imu.accel_D.allFinite()) return;
  if (!aligned_) {
    align(imu);
    last_imu_ = imu;
    return;
  }
  if (last_imu_ && imu.time <= last_imu_->time) return;
  predict(imu);
  last_imu_ = imu;
  if (at_rest_) fuse_rest(imu.time);
}

void Estimator::predict(const ImuInput& imu) {
  const ImuInput& last = last_imu_ ? *last_imu_ : imu;
  const double dt = std::min(to_seconds(imu.time - last.time), kLongestStep_s);

  // Nominal state: mean rate and mean force over the step, attitude at its middle for the force.
  const Vector3d w_D = 0.5 * (imu.gyro_D + last.gyro_D) - state_.gyro_bias_D;
  const Vector3d f_D = 0.5 * (imu.accel_D + last.accel_D) - state_.accel_bias_D;
  const Quaterniond q_middle = state_.q_ND * exp_map(w_D * (0.5 * dt));
  const Matrix3d R_ND = q_middle.toRotationMatrix();
  const Vector3d f_N = R_ND * f_D;
  const Vector3d a_N = f_N + Vector3d(0, 0, params_.gravity_m_s2);
  state_.q_ND = (state_.q_ND * exp_map(w_D * dt)).normalized();
  state_.p_N += state_.v_N * dt + a_N * (0.5 * dt * dt);
  state_.v_N += a_N * dt;
  state_.w_D = imu.gyro_D - state_.gyro_bias_D;
  state_.a_N = a_N;
  state_.time = imu.time;
  history_.add(imu.time, dt, a_N);

  // Covariance: one sample's noise acts over the whole step.
  const Vector3d q_theta = (params_.gyro_noise_rad_s * dt).cwiseAbs2();
  Vector3d q_velocity = (params_.accel_noise_m_s2 * dt).cwiseAbs2();
  // Beyond what rotors can do lies an impact, which one sample tells but roughly.
  const double impact = imu.accel_D.norm() - kFlightForce_g * params_.gravity_m_s2;
  if (impact > 0) q_velocity.array() += impact * impact * dt * dt;
  covariance_.predict(R_ND, f_N, dt, q_theta, q_velocity);
  const auto walk = [dt](double density) { return density * density * dt; };
  covariance_.add_walk(ErrorCovariance::kGyroBias, walk(params_.gyro_bias_walk_rad_s));
  covariance_.add_walk(ErrorCovariance::kAccelBias, walk(params_.accel_bias_walk_m_s2));
  covariance_.add_walk(ErrorCovariance::kEarthField, walk(params_.earth_field_walk_gauss));
  covariance_.add_walk(ErrorCovariance::kBodyField, walk(params_.body_field_walk_gauss));
  covariance_.add_baro_walk(walk(params_.baro_offset_walk_m));
}

// Fusion.

double Estimator::fuse_scalar(const Vector& h, double innovation, double variance) {
  Vector ph;
  const double s = covariance_.innovation_variance(h, variance, ph);
  const double remaining = innovation - h.dot(errors_);
  errors_ += covariance_.update(ph, s) * remaining;
  return remaining * remaining / s;
}

bool Estimator::passes(const Vector& h, double innovation, double variance, double gate,
                       FusionHealth& health) {
  Vector ph;
  const double s = covariance_.innovation_variance(h, variance, ph);
  const double ratio = innovation * innovation / (gate * gate * s);
  health.test_ratio = std::max(health.test_ratio, ratio);
  return ratio <= 1.0;
}

void Estimator::apply_errors() {
  using C = ErrorCovariance;
  state_.q_ND = (exp_map(errors_.segment<3>(C::kTheta)) * state_.q_ND).normalized();
  state_.v_N += errors_.segment<3>(C::kVelocity);
  state_.p_N += errors_.segment<3>(C::kPosition);
  state_.gyro_bias_D += errors_.segment<3>(C::kGyroBias);
  state_.accel_bias_D += errors_.segment<3>(C::kAccelBias);
  state_.earth_field_N += errors_.segment<3>(C::kEarthField);
  state_.body_field_D += errors_.segment<3>(C::kBodyField);
  state_.baro_offset_m += errors_[C::kBaroOffset];
  state_.w_D -= errors_.segment<3>(C::kGyroBias);
  errors_.setZero();
}

void Estimator::fuse_rest(base::SimTime now) {
  const Vector3d& gyro = last_imu_->gyro_D;
  const bool quiet = gyro.norm() < kRestRate_rad_s &&
                     std::abs(last_imu_->accel_D.norm() - params_.gravity_m_s2) < kRestForce_m_s2;
  if (!quiet) {
    rest_samples_ = 0;
    rest_gyro_sum_.setZero();
    rest_since_.reset();
    return;
  }
  if (!rest_since_) rest_since_ = now;
  rest_gyro_sum_ += gyro;
  if (++rest_samples_ < kRestSamples) return;
  const Vector3d rate = rest_gyro_sum_ / rest_samples_ - state_.gyro_bias_D;
  for (int axis = 0; axis < 3; ++axis) {
    const double noise = params_.gyro_noise_rad_s[axis];
    fuse_scalar(Vector::Unit(ErrorCovariance::kGyroBias + axis), rate[axis],
                noise * noise / rest_samples_);
    fuse_scalar(Vector::Unit(ErrorCovariance::kVelocity + axis), -state_.v_N[axis],
                kRestVelocity_m_s * kRestVelocity_m_s);
  }
  apply_errors();
  rest_samples_ = 0;
  rest_gyro_sum_.setZero();
}

double Estimator::rest_s() const {
  return at_rest_ && rest_since_ ? to_seconds(state_.time - *rest_since_) : 0.0;
}

void Estimator::on_magnetometer(base::SimTime time, const Vector3d& field_D) {
  if (!field_D.allFinite()) return;
  if (!aligned_) {
    ++alignment_.mag_samples;
    alignment_.mag += field_D;
    return;
  }
  if (!field_known_) return;
  if (!heading_aligned_) return align_heading(field_D);

  // In N: R (y - body) - earth = [earth]x theta + d_earth + R d_body.
  using C = ErrorCovariance;
  const Matrix3d R_ND = state_.q_ND.toRotationMatrix();
  const Vector3d innovation = R_ND * (field_D - state_.body_field_D) - state_.earth_field_N;
  const Vector3d& m = state_.earth_field_N;
  const double variance = params_.mag_noise_gauss * params_.mag_noise_gauss;
  Matrix3d cross;
  cross << 0, -m.z(), m.y(), m.z(), 0, -m.x(), -m.y(), m.x(), 0;
  std::array<Vector, 3> rows;
  bool good = true;
  mag_.test_ratio = 0;
  for (int axis = 0; axis < 3; ++axis) {
    Vector& h = rows[static_cast<std::size_t>(axis)];
    h.setZero();
    h.segment<3>(C::kTheta) = cross.row(axis).transpose();
    h[C::kEarthField + axis] = 1;
    h.segment<3>(C::kBodyField) = R_ND.row(axis).transpose();
    good = passes(h, innovation[axis], variance, params_.mag_gate, mag_) && good;
  }
  if (!good) {
    ++mag_.rejected;
    return;
  }
  mag_.nis = 0;
  mag_.dimension = 3;
  for (int axis = 0; axis < 3; ++axis) {
    mag_.nis += fuse_scalar(rows[static_cast<std::size_t>(axis)], innovation[axis], variance);
  }
  apply_errors();
  ++mag_.fused;
  mag_.last_fused = time;
}

void Estimator::on_barometer(base::SimTime time, double pressure_pa) {
  if (!std::isfinite(pressure_pa) || pressure_pa <= 0 || !aligned_) return;
  const double origin_alt = projection_ ? projection_->home().alt_m : 0.0;
  const double predicted = origin_alt - state_.p_N.z() + state_.baro_offset_m;
  double innovation = base::isa::altitude_m(pressure_pa) - predicted;
  if (!baro_started_) {
    state_.baro_offset_m += innovation;
    innovation = 0;
    baro_started_ = true;
  }
  Vector h = Vector::Zero();
  h[ErrorCovariance::kPosition + 2] = -1;
  h[ErrorCovariance::kBaroOffset] = 1;
  const double variance = params_.baro_noise_m * params_.baro_noise_m;
  baro_.test_ratio = 0;
  const bool good = passes(h, innovation, variance, params_.baro_gate, baro_);
  const bool patient = to_seconds(time - baro_.last_fused) < kRejectionTimeout_s;
  if (!good && patient) {
    ++baro_.rejected;
    return;
  }
  if (!good) covariance_.reset_block(ErrorCovariance::kBaroOffset, 1, innovation * innovation);
  baro_.nis = fuse_scalar(h, innovation, variance);
  baro_.dimension = 1;
  apply_errors();
  ++baro_.fused;
  baro_.last_fused = time;
}

// Validity.

bool Estimator::velocity_valid() const {
  if (!aligned_ || !projection_) return false;
  const double age = to_seconds(state_.time - gps_velocity_.last_fused);
  return age < kFusionTimeout_s &&
         covariance_.deviation(ErrorCovariance::kVelocity).head<2>().maxCoeff() <
             kVelocityUsable_m_s;
}

bool Estimator::position_valid() const {
  if (!aligned_ || !projection_) return false;
  const double age = to_seconds(state_.time - gps_position_.last_fused);
  return age < kFusionTimeout_s &&
         covariance_.deviation(ErrorCovariance::kPosition).head<2>().maxCoeff() < kPositionUsable_m;
}

bool Estimator::height_valid() const {
  if (!aligned_ || !baro_started_) return false;
  const double baro_age = to_seconds(state_.time - baro_.last_fused);
  const double gps_age = to_seconds(state_.time - gps_position_.last_fused);
  return std::min(baro_age, projection_ ? gps_age : baro_age) < kFusionTimeout_s;
}

}  // namespace cas::fcu
