// SPDX-License-Identifier: BSD-3-Clause
// Fusion of position fixes: late by their own stamp, gated, with an origin found at rest.
#include <cmath>

#include "base/earth/frames.hpp"
#include "fcu/estimation/estimator.hpp"

namespace cas::fcu {
namespace {

using base::to_seconds;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kUsableFix = 3;
constexpr double kRejectionTimeout_s = 4.0;
constexpr int kVelocityRejections = 5;       // in a row, then the fixes are believed
constexpr double kOriginDeviation_m = 0.05;  // horizontal, for a final origin
constexpr double kOriginPatience_s = 12.0;   // ... or what is reached by then

}  // namespace

void Estimator::on_gps(const GpsInput& fix) {
  if (fix.fix_type < kUsableFix || !fix.velocity_N.allFinite()) return;
  if (!field_known_) set_field_from_model(fix.place);
  if (!aligned_) return;
  if (gps_position_.fused + gps_position_.rejected == 0) accept_first_fix(fix);
  const Vector3d measured_N = projection_->to_local(fix.place);
  fuse_gps_velocity(fix);
  fuse_gps_position(fix, measured_N);
  if (!origin_final_) settle_origin();
}

void Estimator::accept_first_fix(const GpsInput& fix) {
  first_fix_ = state_.time;
  using C = ErrorCovariance;
  if (!projection_) {
    projection_ = base::LocalProjection(fix.place);
    // The pressure altitude was compared with altitude zero so far.
    state_.baro_offset_m -= fix.place.alt_m - -state_.p_N.z();
    state_.p_N.setZero();
  } else {
    const Vector3d p_N = projection_->to_local(fix.place);
    state_.baro_offset_m -= -p_N.z() + state_.p_N.z();
    state_.p_N = p_N;
  }
  const double horizontal = params_.gps_position_noise_m * params_.gps_position_noise_m;
  const double vertical = params_.gps_height_noise_m * params_.gps_height_noise_m;
  covariance_.set_block(C::kPosition, Vector3d(horizontal, horizontal, vertical) * 1e4);
  covariance_.reset_block(C::kBaroOffset, 1,
                          params_.baro_offset_initial_m * params_.baro_offset_initial_m);
  history_.clear();
}

ErrorCovariance::Vector Estimator::velocity_row(int axis, double age_s) const {
  // v(then) = v - age a, and the error of a is -[f]x theta - R d_accel_bias.
  using C = ErrorCovariance;
  Vector h = Vector::Zero();
  h[C::kVelocity + axis] = 1;
  if (age_s > 0) {
    const Matrix3d R_ND = state_.q_ND.toRotationMatrix();
    const Vector3d f = state_.a_N - Vector3d(0, 0, params_.gravity_m_s2);
    Matrix3d cross;
    cross << 0, -f.z(), f.y(), f.z(), 0, -f.x(), -f.y(), f.x(), 0;
    h.segment<3>(C::kTheta) = age_s * cross.row(axis).transpose();
    h.segment<3>(C::kAccelBias) = age_s * R_ND.row(axis).transpose();
  }
  return h;
}

ErrorCovariance::Vector Estimator::position_row(int axis, double age_s) const {
  // p(then) = p - age v + age^2 / 2 a.
  using C = ErrorCovariance;
  Vector h = Vector::Zero();
  h[C::kPosition + axis] = 1;
  if (age_s > 0) {
    h = velocity_row(axis, age_s) * (-0.5 * age_s);
    h[C::kVelocity + axis] = -age_s;
    h[C::kPosition + axis] = 1;
  }
  return h;
}

void Estimator::fuse_gps_velocity(const GpsInput& fix) {
  const MotionHistory::Change change = history_.since(fix.time);
  const double variance = params_.gps_velocity_noise_m_s * params_.gps_velocity_noise_m_s;
  const Vector3d innovation = fix.velocity_N - (state_.v_N - change.velocity);
  bool good = true;
  gps_velocity_.test_ratio = 0;
  for (int axis = 0; axis < 3; ++axis) {
    good = passes(velocity_row(axis, change.age_s), innovation[axis], variance,
                  params_.gps_velocity_gate, gps_velocity_) &&
           good;
  }
  if (!good) {
    ++gps_velocity_.rejected;
    if (++velocity_rejections_ < kVelocityRejections) return;
    // It is the prediction that is wrong: a blow that the accelerometer missed.
    const double doubt = innovation.squaredNorm();
    covariance_.add_walk(ErrorCovariance::kVelocity, doubt);
    covariance_.add_walk(ErrorCovariance::kPosition, doubt);
  }
  velocity_rejections_ = 0;
  gps_velocity_.nis = 0;
  gps_velocity_.dimension = 3;
  for (int axis = 0; axis < 3; ++axis) {
    gps_velocity_.nis += fuse_scalar(velocity_row(axis, change.age_s), innovation[axis], variance);
  }
  apply_errors();
  ++gps_velocity_.fused;
  gps_velocity_.last_fused = state_.time;
}

void Estimator::fuse_gps_position(const GpsInput& fix, const Vector3d& measured_N) {
  const MotionHistory::Change change = history_.since(fix.time);
  const Vector3d v_then = state_.v_N - change.velocity;
  const Vector3d p_then = state_.p_N - v_then * change.age_s - change.position;
  const Vector3d innovation = measured_N - p_then;
  const double horizontal = params_.gps_position_noise_m * params_.gps_position_noise_m;
  const double vertical = params_.gps_height_noise_m * params_.gps_height_noise_m;
  const Vector3d variance(horizontal, horizontal, vertical);
  bool good = true;
  gps_position_.test_ratio = 0;
  for (int axis = 0; axis < 3; ++axis) {
    good = passes(position_row(axis, change.age_s), innovation[axis], variance[axis],
                  params_.gps_position_gate, gps_position_) &&
           good;
  }
  if (!good) {
    ++gps_position_.rejected;
    if (to_seconds(state_.time - gps_position_.last_fused) > kRejectionTimeout_s) {
      reset_to_fix(fix, measured_N);
    }
    return;
  }
  gps_position_.nis = 0;
  gps_position_.dimension = 3;
  for (int axis = 0; axis < 3; ++axis) {
    gps_position_.nis +=
        fuse_scalar(position_row(axis, change.age_s), innovation[axis], variance[axis]);
  }
  apply_errors();
  ++gps_position_.fused;
  gps_position_.last_fused = state_.time;
}

void Estimator::reset_to_fix(const GpsInput& fix, const Vector3d& measured_N) {
  using C = ErrorCovariance;
  last_position_reset_N_ = measured_N - state_.p_N;
  ++position_resets_;
  state_.p_N.head<2>() = measured_N.head<2>();
  state_.v_N = fix.velocity_N;
  last_position_reset_N_.z() = 0;
  const double horizontal = params_.gps_position_noise_m * params_.gps_position_noise_m;
  const double velocity = params_.gps_velocity_noise_m_s * params_.gps_velocity_noise_m_s;
  covariance_.reset_block(C::kPosition, 2, horizontal);
  covariance_.reset_block(C::kVelocity, 3, velocity);
  gps_position_.last_fused = state_.time;
  gps_velocity_.last_fused = state_.time;
}

void Estimator::settle_origin() {
  const double waited = to_seconds(state_.time - first_fix_);
  const double deviation = covariance_.deviation(ErrorCovariance::kPosition).head<2>().maxCoeff();
  if (deviation > kOriginDeviation_m && waited < kOriginPatience_s) return;
  origin_final_ = true;
  if (origin_given_) return;
  // The place the vehicle stands at, as well as it is known by now, becomes the origin.
  const base::Geodetic origin = projection_->to_geodetic(state_.p_N);
  projection_ = base::LocalProjection(origin);
  state_.p_N.setZero();
}

}  // namespace cas::fcu
