// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace cas::fcu {

/// Covariance of the estimator's error states and the linear algebra on it.
///
/// Error states: rotation of D in N expressed in N (rad), velocity in N (m/s), position in N (m),
/// gyro bias in D (rad/s), accelerometer bias in D (m/s^2), earth field in N (gauss), body field
/// bias in D (gauss), barometer offset (m). The true attitude is exp(theta) * estimated attitude.
class ErrorCovariance {
 public:
  static constexpr int kTheta = 0, kVelocity = 3, kPosition = 6, kGyroBias = 9, kAccelBias = 12,
                       kEarthField = 15, kBodyField = 18, kBaroOffset = 21, kStates = 22;
  using Vector = Eigen::Matrix<double, kStates, 1>;
  using Matrix = Eigen::Matrix<double, kStates, kStates>;

  /// In the units of the states, squared.
  const Matrix& matrix() const { return p_; }
  double variance(int state) const { return p_(state, state); }
  /// 1 sigma of the three states from `block` (kTheta, kVelocity, ...) on.
  Eigen::Vector3d deviation(int block) const;

  /// Forgets a block of `size` states: given variance, no correlations.
  void reset_block(int block, int size, double variance);
  /// The same for three states, each with its own variance.
  void set_block(int block, const Eigen::Vector3d& variance);

  /// Carries the covariance over one IMU step.
  /// @param R_ND      attitude of D in N
  /// @param f_N       specific force in N, m/s^2
  /// @param dt        s
  /// @param q_theta   variance added to the rotation error, axes of D, rad^2
  /// @param q_velocity  variance added to the velocity error, axes of D, m^2/s^2
  void predict(const Eigen::Matrix3d& R_ND, const Eigen::Vector3d& f_N, double dt,
               const Eigen::Vector3d& q_theta, const Eigen::Vector3d& q_velocity);
  /// Adds the same variance to three states.
  void add_walk(int block, double variance);
  /// Adds variance to the barometer offset, m^2.
  void add_baro_walk(double variance) { p_(kBaroOffset, kBaroOffset) += variance; }

  /// Innovation variance of a scalar measurement h' x with variance r; leaves P h in `ph`.
  double innovation_variance(const Vector& h, double r, Vector& ph) const;
  /// Scalar Kalman update with the results of innovation_variance. @return the gain
  Vector update(const Vector& ph, double innovation_variance);

 private:
  /// Three rows (columns) of P at `to`, less `factor` times those at `from`: one product each, so
  /// that its 3x22 expression is compiled once.
  void subtract_rows(int to, const Eigen::Matrix3d& factor, int from);
  void subtract_columns(int to, const Eigen::Matrix3d& factor, int from);
  void keep_positive();

  Matrix p_ = Matrix::Zero();
};

}  // namespace cas::fcu
