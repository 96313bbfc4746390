// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/error_covariance.hpp"

#include <algorithm>

namespace cas::fcu {
namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace

Eigen::Vector3d ErrorCovariance::deviation(int block) const {
  return p_.diagonal().segment<3>(block).cwiseMax(0.0).cwiseSqrt();
}

void ErrorCovariance::reset_block(int block, int size, double variance) {
  p_.middleRows(block, size).setZero();
  p_.middleCols(block, size).setZero();
  for (int i = block; i < block + size; ++i) p_(i, i) = variance;
}

void ErrorCovariance::set_block(int block, const Eigen::Vector3d& variance) {
  reset_block(block, 3, 0);
  p_.diagonal().segment<3>(block) = variance;
}

void ErrorCovariance::predict(const Eigen::Matrix3d& R_ND, const Eigen::Vector3d& f_N, double dt,
                              const Eigen::Vector3d& q_theta, const Eigen::Vector3d& q_velocity) {
  // F = I + E; the rows of E that are not zero:
  //   theta: -R dt at the gyro bias      velocity: -[f]x dt at theta, -R dt at the accel bias
  //   position: dt at the velocity
  const Eigen::Matrix3d r_dt = R_ND * dt;
  const Eigen::Matrix3d f_dt = skew(f_N) * dt;

  // Rows: F P. Position before velocity before theta, so that each uses the old values.
  p_.middleRows<3>(kPosition) += dt * p_.middleRows<3>(kVelocity);
  subtract_rows(kVelocity, f_dt, kTheta);
  subtract_rows(kVelocity, r_dt, kAccelBias);
  subtract_rows(kTheta, r_dt, kGyroBias);
  // Columns: (F P) F'.
  p_.middleCols<3>(kPosition) += dt * p_.middleCols<3>(kVelocity);
  subtract_columns(kVelocity, f_dt, kTheta);
  subtract_columns(kVelocity, r_dt, kAccelBias);
  subtract_columns(kTheta, r_dt, kGyroBias);

  p_.block<3, 3>(kTheta, kTheta).noalias() += R_ND * q_theta.asDiagonal() * R_ND.transpose();
  p_.block<3, 3>(kVelocity, kVelocity).noalias() +=
      R_ND * q_velocity.asDiagonal() * R_ND.transpose();
  // No update shrinks a difference between the halves that rounding has made, and each step carries
  // it on: within two hours it would outgrow P.
  p_.triangularView<Eigen::StrictlyLower>() = p_.transpose();
}

void ErrorCovariance::subtract_rows(int to, const Eigen::Matrix3d& factor, int from) {
  p_.middleRows<3>(to).noalias() -= factor * p_.middleRows<3>(from);
}

void ErrorCovariance::subtract_columns(int to, const Eigen::Matrix3d& factor, int from) {
  p_.middleCols<3>(to).noalias() -= p_.middleCols<3>(from) * factor.transpose();
}

void ErrorCovariance::add_walk(int block, double variance) {
  p_.diagonal().segment<3>(block).array() += variance;
}

double ErrorCovariance::innovation_variance(const Vector& h, double r, Vector& ph) const {
  ph.setZero();
  for (int i = 0; i < kStates; ++i) {
    if (h[i] != 0) ph.noalias() += p_.col(i) * h[i];
  }
  return h.dot(ph) + r;
}

ErrorCovariance::Vector ErrorCovariance::update(const Vector& ph, double innovation_variance) {
  const Vector gain = ph / innovation_variance;
  p_.noalias() -= gain * ph.transpose();
  keep_positive();
  return gain;
}

void ErrorCovariance::keep_positive() {
  constexpr double kSmallestVariance = 1e-14;
  for (int i = 0; i < kStates; ++i) p_(i, i) = std::max(p_(i, i), kSmallestVariance);
}

}  // namespace cas::fcu
