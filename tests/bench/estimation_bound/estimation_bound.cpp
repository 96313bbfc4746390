// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/estimation_bound/estimation_bound.hpp"

#include <Eigen/LU>
#include <cmath>

#include "base/earth/gravity.hpp"
#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"

namespace cas::fcu {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Order of the states: rotation, velocity, position, gyro bias, accel bias, earth field, body
// field, barometer offset.
constexpr int kStates = 22;
using Matrix = Eigen::Matrix<double, kStates, kStates>;

constexpr double kGravity_m_s2 = base::kStandardGravity_m_s2;

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

double squared(double x) { return x * x; }

class Riccati {
 public:
  Riccati(const SensorFigures& figures, const Vector3d& field_N, bool assumed_walks)
      : p_(figures.params),
        rates_(figures.rates),
        field_N_(field_N),
        imu_gate_(figures.rates.imu_hz),
        gps_gate_(figures.rates.gps_hz),
        mag_gate_(figures.rates.mag_hz),
        baro_gate_(figures.rates.baro_hz) {
    const double dt = 1 / rates_.imu_hz;
    // Level and hovering: specific force is -g along Nz, D lies along N.
    transition_.setIdentity();
    transition_.block<3, 3>(0, 9) = -dt * Matrix3d::Identity();
    transition_.block<3, 3>(3, 0) = -dt * cross(Vector3d(0, 0, -kGravity_m_s2));
    transition_.block<3, 3>(3, 12) = -dt * Matrix3d::Identity();
    transition_.block<3, 3>(6, 3) = dt * Matrix3d::Identity();
    noise_.setZero();
    noise_.diagonal().segment<3>(0) = (dt * p_.gyro_noise_rad_s).cwiseAbs2();
    noise_.diagonal().segment<3>(3) = (dt * p_.accel_noise_m_s2).cwiseAbs2();
    const double gyro = assumed_walks ? p_.gyro_bias_walk_rad_s : figures.gyro_bias_walk_rad_s;
    const double accel = assumed_walks ? p_.accel_bias_walk_m_s2 : figures.accel_bias_walk_m_s2;
    const double baro = assumed_walks ? p_.baro_offset_walk_m : figures.baro_offset_walk_m;
    noise_.diagonal().segment<3>(9).setConstant(dt * squared(gyro));
    noise_.diagonal().segment<3>(12).setConstant(dt * squared(accel));
    if (assumed_walks) {
      noise_.diagonal().segment<3>(15).setConstant(dt * squared(p_.earth_field_walk_gauss));
      noise_.diagonal().segment<3>(18).setConstant(dt * squared(p_.body_field_walk_gauss));
    }
    noise_(21, 21) = dt * squared(baro);

    covariance_.setZero();
    auto d = covariance_.diagonal();
    d.segment<3>(0).setConstant(squared(p_.tilt_initial_rad));
    d.segment<3>(3).setConstant(squared(0.5));
    d.segment<3>(6).setConstant(squared(100));
    d.segment<3>(9).setConstant(squared(p_.gyro_bias_initial_rad_s));
    d.segment<3>(12).setConstant(squared(p_.accel_bias_initial_m_s2));
    d.segment<3>(15).setConstant(squared(p_.earth_field_initial_gauss));
    d.segment<3>(18).setConstant(squared(p_.body_field_initial_gauss));
    d[21] = squared(p_.baro_offset_initial_m);
  }

  /// One IMU period.
  void step(bool at_rest) {
    ++count_;
    const base::Duration time = base::from_seconds(static_cast<double>(count_) / rates_.imu_hz);
    covariance_ = transition_ * covariance_ * transition_.transpose() + noise_;
    if (at_rest) {
      for (int axis = 0; axis < 3; ++axis) {
        update(unit(9 + axis), squared(p_.gyro_noise_rad_s[axis]));
        update(unit(3 + axis), squared(kRestVelocity_m_s));
      }
    }
    if (mag_gate_.due(time)) {
      const Matrix3d turn = cross(field_N_);
      for (int axis = 0; axis < 3; ++axis) {
        Vector h = unit(15 + axis) + unit(18 + axis);
        h.segment<3>(0) = turn.row(axis).transpose();
        update(h, squared(p_.mag_noise_gauss));
      }
    }
    if (baro_gate_.due(time)) update(unit(21) - unit(8), squared(p_.baro_noise_m));
    if (!gps_gate_.due(time)) return;
    for (int axis = 0; axis < 3; ++axis) {
      update(unit(6 + axis), squared(axis < 2 ? p_.gps_position_noise_m : p_.gps_height_noise_m));
      update(unit(3 + axis), squared(p_.gps_velocity_noise_m_s));
    }
  }

  const Matrix& covariance() const { return covariance_; }

 private:
  using Vector = Eigen::Matrix<double, kStates, 1>;
  static Vector unit(int i) { return Vector::Unit(i); }

  /// Joseph form: stays symmetric and positive.
  void update(const Vector& h, double r) {
    const Vector gain = covariance_ * h / (h.dot(covariance_ * h) + r);
    const Matrix keep = Matrix::Identity() - gain * h.transpose();
    covariance_ = keep * covariance_ * keep.transpose() + r * gain * gain.transpose();
  }

  EstimatorParams p_;
  SensorRates rates_;
  Vector3d field_N_;
  base::RateGate imu_gate_, gps_gate_, mag_gate_, baro_gate_;
  Matrix transition_, noise_, covariance_;
  std::int64_t count_ = 0;
};

struct Mean {
  Vector3d position = Vector3d::Zero(), velocity = Vector3d::Zero(), attitude = Vector3d::Zero();
  int count = 0;
  void add(const Matrix& p) {
    attitude += p.diagonal().segment<3>(0);
    velocity += p.diagonal().segment<3>(3);
    position += p.diagonal().segment<3>(6);
    ++count;
  }
  EstimationBound root() const {
    return {(position / count).cwiseSqrt(), (velocity / count).cwiseSqrt(),
            (attitude / count).cwiseSqrt()};
  }
};

}  // namespace

EstimationBound flight_bound(const SensorFigures& figures, const BoundScenario& scenario) {
  Riccati riccati(figures, Vector3d(scenario.earth_field_gauss_N), false);
  const auto steps = [&](double seconds) {
    return static_cast<int>(std::lround(seconds * figures.rates.imu_hz));
  };
  for (int i = 0; i < steps(scenario.rest_s); ++i) riccati.step(true);
  for (int i = 0; i < steps(scenario.settle_s); ++i) riccati.step(false);
  Mean mean;
  for (int i = 0; i < steps(scenario.average_s); ++i) {
    riccati.step(false);
    mean.add(riccati.covariance());
  }
  return mean.root();
}

EstimationBound steady_bound(const SensorFigures& figures) {
  constexpr double kSeconds = 1500;  // the slowest state settles in a fraction of it
  constexpr double kAverage_s = 2;
  const BoundScenario scenario;
  Riccati riccati(figures, Vector3d(scenario.earth_field_gauss_N), true);
  const auto all = static_cast<int>(kSeconds * figures.rates.imu_hz);
  const auto last = static_cast<int>(kAverage_s * figures.rates.imu_hz);
  Mean mean;
  for (int i = 0; i < all; ++i) {
    riccati.step(i < static_cast<int>(5 * figures.rates.imu_hz));
    if (i >= all - last) mean.add(riccati.covariance());
  }
  return mean.root();
}

}  // namespace cas::fcu
