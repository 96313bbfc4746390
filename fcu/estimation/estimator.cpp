// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/estimator.hpp"

#include <algorithm>
#include <array>
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
constexpr double kRejectionTimeout_s = 4.0;  // then the measurements are believed again
constexpr int kRestSamples = 10;             // IMU samples per rest measurement
constexpr double kFlightForce_g = 2.5;       // specific force of the hardest manoeuvre
constexpr double kVelocityUsable_m_s = 1.0;  // larger deviations: no velocity
constexpr double kPositionUsable_m = 10.0;   // larger deviations: no position

constexpr double kHeadingUnknown_rad = 1.8;   // uniform over the circle
constexpr double kVelocityInitial_m_s = 0.5;  // 1 sigma of the velocity at the start
constexpr int kUsableFix = 3;                 // GPS_FIX_TYPE_3D_FIX
constexpr int kVelocityRejections = 5;        // in a row, then they may be believed
constexpr double kOriginDeviation_m = 0.05;   // horizontal, for a final origin
constexpr double kOriginPatience_s = 12.0;    // ... or the deviation reached by then

double square(double x) { return x * x; }

/// The matrix that turns a vector u into v x u.
Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

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

// Alignment.

void Estimator::align(const ImuInput& imu) {
  alignment_.on_accelerometer(imu.time, imu.accel_D,
                              indicates_rest(imu.gyro_D, imu.accel_D, params_.gravity_m_s2));
  const bool with_heading = alignment_.has_heading() && field_known_;
  if (!alignment_.complete(with_heading)) return;
  state_.time = imu.time;
  state_.q_ND = alignment_.attitude(state_.earth_field_N, with_heading);
  state_.gyro_bias_D.setZero();
  state_.accel_bias_D.setZero();
  heading_aligned_ = with_heading;
  start_covariance();
  history_.clear();
  aligned_ = true;
}

/// If the first fix comes after the alignment, the declination is known late: the heading is then
/// taken from the present tilt and one magnetometer sample. Position and velocity stay as they are.
void Estimator::align_heading(const Vector3d& field_D) {
  const Vector3d rpy = base::euler_rpy(state_.q_ND);
  state_.q_ND = attitude_from_field(rpy.x(), rpy.y(), field_D, state_.earth_field_N);
  covariance_.reset_block(ErrorCovariance::kTheta + 2, 1, square(params_.tilt_initial_rad));
  history_.clear();
  heading_aligned_ = true;
}

void Estimator::start_covariance() {
  using C = ErrorCovariance;
  const double tilt = square(params_.tilt_initial_rad);
  const double heading = square(heading_aligned_ ? params_.tilt_initial_rad : kHeadingUnknown_rad);
  covariance_.set_block(C::kTheta, Vector3d(tilt, tilt, heading));
  covariance_.reset_block(C::kVelocity, 3, square(kVelocityInitial_m_s));
  covariance_.reset_block(C::kPosition, 3, square(params_.gps_position_noise_m));
  covariance_.reset_block(C::kGyroBias, 3, square(params_.gyro_bias_initial_rad_s));
  covariance_.reset_block(C::kAccelBias, 3, square(params_.accel_bias_initial_m_s2));
  covariance_.reset_block(C::kEarthField, 3, square(params_.earth_field_initial_gauss));
  covariance_.reset_block(C::kBodyField, 3, square(params_.body_field_initial_gauss));
  covariance_.reset_block(C::kBaroOffset, 1, square(params_.baro_offset_initial_m));
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

void Estimator::forget_imu_biases() {
  if (!aligned_) return;
  using C = ErrorCovariance;
  state_.gyro_bias_D.setZero();
  state_.accel_bias_D.setZero();
  covariance_.reset_block(C::kGyroBias, 3, square(params_.gyro_bias_initial_rad_s));
  covariance_.reset_block(C::kAccelBias, 3, square(params_.accel_bias_initial_m_s2));
}

void Estimator::fuse_rest(base::SimTime now) {
  const Vector3d& gyro = last_imu_->gyro_D;
  if (!indicates_rest(gyro, last_imu_->accel_D, params_.gravity_m_s2)) {
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
                square(kRestVelocity_m_s));
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
    alignment_.on_magnetometer(field_D);
    return;
  }
  if (!field_known_) return;
  if (!heading_aligned_) return align_heading(field_D);

  // In N: R (y - body) - earth = [earth]x theta + d_earth + R d_body.
  using C = ErrorCovariance;
  const Matrix3d R_ND = state_.q_ND.toRotationMatrix();
  const Vector3d innovation = R_ND * (field_D - state_.body_field_D) - state_.earth_field_N;
  const double variance = square(params_.mag_noise_gauss);
  const Matrix3d cross = cross_matrix(state_.earth_field_N);
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
  const double variance = square(params_.baro_noise_m);
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

// Position fixes: late by their own stamp, gated, with an origin found at rest.

void Estimator::on_gps(const GpsInput& fix) {
  if (fix.fix_type < kUsableFix || !fix.velocity_N.allFinite()) return;
  if (!field_known_) set_field_from_model(fix.place);
  if (!aligned_) return;
  if (gps_position_.fused + gps_position_.rejected == 0) accept_first_fix(fix);
  const Vector3d measured_N = projection_->to_local(fix.place);
  fuse_gps_velocity(fix, measured_N);
  fuse_gps_position(fix, measured_N);
  if (!origin_final_) settle_origin();
}

std::optional<Estimator::FixOffset> Estimator::offset_of(const GpsInput& fix) const {
  if (!projection_ || !position_valid()) return std::nullopt;
  const MotionHistory::Change change = history_.since(fix.time);
  const Vector3d v_then = state_.v_N - change.velocity;
  const Vector3d p_then = state_.p_N - v_then * change.age_s - change.position;
  return FixOffset{.position_m = (projection_->to_local(fix.place) - p_then).head<2>().norm(),
                   .velocity_m_s = (fix.velocity_N - v_then).head<2>().norm()};
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
  const double horizontal = square(params_.gps_position_noise_m);
  const double vertical = square(params_.gps_height_noise_m);
  covariance_.set_block(C::kPosition, Vector3d(horizontal, horizontal, vertical) * 1e4);
  covariance_.reset_block(C::kBaroOffset, 1, square(params_.baro_offset_initial_m));
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
    const Matrix3d cross = cross_matrix(f);
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

/// Whether the velocities rejected in a row are the change of the positions that came with them.
bool Estimator::velocity_fits_positions(const GpsInput& fix, const Vector3d& measured_N) const {
  constexpr double kDeviations = 2;
  const double span_s = to_seconds(fix.time - first_rejected_);
  if (span_s <= 0) return true;
  const Vector3d by_positions = (measured_N - first_rejected_N_) / span_s;
  const Vector3d off = rejected_velocity_sum_N_ / velocity_rejections_ - by_positions;
  const auto most = [&](double position_noise_m) {
    return kDeviations *
           std::hypot(std::sqrt(2.0) * position_noise_m / span_s, params_.gps_velocity_noise_m_s);
  };
  return off.head<2>().cwiseAbs().maxCoeff() < most(params_.gps_position_noise_m) &&
         std::abs(off.z()) < most(params_.gps_height_noise_m);
}

void Estimator::fuse_gps_velocity(const GpsInput& fix, const Vector3d& measured_N) {
  const MotionHistory::Change change = history_.since(fix.time);
  const double variance = square(params_.gps_velocity_noise_m_s);
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
    if (velocity_rejections_ == 0) {
      first_rejected_ = fix.time;
      first_rejected_N_ = measured_N;
      rejected_velocity_sum_N_.setZero();
    }
    rejected_velocity_sum_N_ += fix.velocity_N;
    if (++velocity_rejections_ < kVelocityRejections) return;
    if (!velocity_fits_positions(fix, measured_N)) return;
    // The prediction is wrong, not the fix: the accelerometer missed a blow.
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
  const double horizontal = square(params_.gps_position_noise_m);
  const double vertical = square(params_.gps_height_noise_m);
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
  const double horizontal = square(params_.gps_position_noise_m);
  const double velocity = square(params_.gps_velocity_noise_m_s);
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
  // The present estimate of the resting position becomes the origin.
  const base::Geodetic origin = projection_->to_geodetic(state_.p_N);
  projection_ = base::LocalProjection(origin);
  state_.p_N.setZero();
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
