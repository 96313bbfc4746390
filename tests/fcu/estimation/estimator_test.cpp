// SPDX-License-Identifier: BSD-3-Clause
// The estimator's errors against its own covariance and against the bound, over seeded flights.
#include "fcu/estimation/estimator.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "tests/bench/estimation_bound/estimation_bound.hpp"
#include "tests/fcu/support/closed_loop.hpp"
#include "tests/fcu/support/flight_statistics.hpp"
#include "tests/support/paths.hpp"

namespace cas::fcu {
namespace {

using Eigen::Vector3d;
using test::ClosedLoop;
using test::FlightStatistics;
using test::LoopOptions;

/// A flight whose constant sensor errors are drawn from the filter's own statistics.
LoopOptions drawn_errors(std::uint64_t seed, double gps_delay_s) {
  base::NormalRandom random(base::derive_seed(seed, "errors"));
  const auto draw = [&random](double sigma) {
    return Vector3d(sigma * random(), sigma * random(), sigma * random());
  };
  const EstimatorParams expected;
  LoopOptions options;
  options.seed = seed;
  options.noise.gyro_bias_rad_s = draw(expected.gyro_bias_initial_rad_s);
  options.noise.accel_bias_m_s2 = draw(expected.accel_bias_initial_m_s2);
  options.noise.mag_bias_gauss = draw(expected.body_field_initial_gauss);
  options.noise.field_error_gauss = draw(expected.earth_field_initial_gauss);
  options.noise.baro_offset_pa = 40 * random();
  options.noise.gps_delay_s = gps_delay_s;
  return options;
}

/// Means of normalised squares: the expected value of each is its dimension.
struct Consistency {
  double motion = 0, attitude = 0, velocity = 0, position = 0, gyro_bias = 0;
  double nis_position = 0, nis_velocity = 0, nis_baro = 0, nis_mag = 0;
  int count = 0;

  void add(ClosedLoop& loop) {
    using C = ErrorCovariance;
    const Estimator& estimator = loop.fcu().estimator();
    const EstimatorState& s = estimator.state();
    const C::Matrix& p = estimator.covariance().matrix();
    Eigen::Quaterniond turn = loop.truth().q_ND * s.q_ND.inverse();
    if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
    Eigen::Matrix<double, 9, 1> error;
    error << 2 * turn.vec(), loop.truth().v_N - s.v_N, loop.truth().p_N - s.p_N;
    const Eigen::Matrix<double, 9, 9> p9 = p.topLeftCorner<9, 9>();
    motion += error.dot(p9.inverse() * error);
    const auto block = [&](int at) {
      const Eigen::Matrix3d p3 = p.block<3, 3>(at, at);
      const Vector3d e = error.segment<3>(at);
      return e.dot(p3.inverse() * e);
    };
    attitude += block(C::kTheta);
    velocity += block(C::kVelocity);
    position += block(C::kPosition);
    const Vector3d bias = loop.noise().gyro_bias_rad_s - s.gyro_bias_D;
    const Eigen::Matrix3d pb = p.block<3, 3>(C::kGyroBias, C::kGyroBias);
    gyro_bias += bias.dot(pb.inverse() * bias);
    nis_position += estimator.gps_position().nis;
    nis_velocity += estimator.gps_velocity().nis;
    nis_baro += estimator.baro().nis;
    nis_mag += estimator.mag().nis;
    ++count;
  }
};

class EstimatorConsistency : public testing::TestWithParam<double> {};

TEST_P(EstimatorConsistency, ErrorsAgreeWithTheCovarianceInManoeuvres) {
  constexpr int kFlights = 30;
  Consistency sum;
  for (int seed = 1; seed <= kFlights; ++seed) {
    ClosedLoop loop(drawn_errors(static_cast<std::uint64_t>(seed), GetParam()));
    ASSERT_TRUE(loop.fly_to_hover(2.5)) << seed;
    loop.keep_packets = false;
    for (int i = 0; i < 40; ++i) {
      if (i % 8 == 4) {
        const bool out = i % 16 == 4;
        loop.go_to(out ? 4 : 0, 3, out ? 3.5 : 2.5, static_cast<float>(i % 16) / 5);
      }
      loop.run(1.037);
      sum.add(loop);
    }
  }
  // Errors of one flight hang together: some 30 x 5 independent draws, so a few parts in ten.
  constexpr double kShare = 0.25;
  const double n = sum.count;
  EXPECT_NEAR(sum.motion / n, 9, 9 * kShare);
  EXPECT_NEAR(sum.attitude / n, 3, 3 * kShare);
  EXPECT_NEAR(sum.velocity / n, 3, 3 * kShare);
  EXPECT_NEAR(sum.position / n, 3, 3 * kShare);
  EXPECT_NEAR(sum.gyro_bias / n, 3, 3 * kShare);
  // Innovations are independent of each other: 1200 draws.
  constexpr double kInnovationShare = 0.15;
  EXPECT_NEAR(sum.nis_position / n, 3, 3 * kInnovationShare);
  EXPECT_NEAR(sum.nis_velocity / n, 3, 3 * kInnovationShare);
  EXPECT_NEAR(sum.nis_baro / n, 1, kInnovationShare);
  EXPECT_NEAR(sum.nis_mag / n, 3, 3 * kInnovationShare);
}

INSTANTIATE_TEST_SUITE_P(Delays, EstimatorConsistency, testing::Values(0.0, 0.12),
                         [](const auto& test) { return test.param > 0 ? "LateFixes" : "Prompt"; });

TEST(Estimator, HoverStaysWithinItsMultiplesOfTheBound) {
  constexpr int kFlights = 8;  // flight_figures pools 30
  FlightStatistics pooled;
  for (int seed = 1; seed <= kFlights; ++seed) {
    LoopOptions options;
    options.seed = static_cast<std::uint64_t>(seed);
    ClosedLoop loop(options);
    ASSERT_TRUE(loop.fly_to_hover(2.5)) << seed;
    loop.keep_packets = false;
    loop.go_to(0, 0, 2.5, 0.0F);
    loop.run(20);
    loop.run(40, [&] { pooled.add(loop, {0, 0, -2.5}, 0); });
  }
  const FlightStatistics rms = pooled.rms();
  const base::Vehicle vehicle =
      base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/iris_paper.yaml");
  const EstimationBound bound = flight_bound(sensor_figures(vehicle.sensors));
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(rms.estimate_m[axis], 1.3 * bound.position_m[axis]) << axis;
    EXPECT_LE(rms.tracking_m[axis], 1.5 * bound.position_m[axis]) << axis;
  }
  std::printf(
      "true x %.4f y %.4f z %.4f m yaw %.4f rad; estimate x %.4f y %.4f z %.4f m; "
      "bound x %.4f y %.4f z %.4f m; [HILS] SITL x 0.0068 y 0.0050 z 0.0449 m yaw 0.0342\n",
      rms.tracking_m[0], rms.tracking_m[1], rms.tracking_m[2], rms.yaw_rad, rms.estimate_m[0],
      rms.estimate_m[1], rms.estimate_m[2], bound.position_m.x(), bound.position_m.y(),
      bound.position_m.z());
}

// Rounding makes the two halves of P differ. No update takes the difference back, and it grows with
// the sixth power of time: from gyro bias to position over three integrals, on both sides.
TEST(ErrorCovariance, StaysSymmetricOverAnHour) {
  using C = ErrorCovariance;
  constexpr double kStep_s = 0.004;
  C covariance;
  covariance.set_block(C::kTheta, Vector3d::Constant(1e-2));
  covariance.set_block(C::kVelocity, Vector3d::Constant(1e-1));
  covariance.set_block(C::kPosition, Vector3d::Constant(1));
  covariance.set_block(C::kGyroBias, Vector3d::Constant(1e-4));
  covariance.set_block(C::kAccelBias, Vector3d::Constant(1e-2));
  C::Vector ph;
  for (int step = 0; step < 900'000; ++step) {
    const double tilt = 0.1 * std::sin(0.3 * kStep_s * step);
    const Eigen::Matrix3d attitude =
        Eigen::AngleAxisd(tilt, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    covariance.predict(attitude, {0.5 * tilt, tilt, -9.8}, kStep_s, Vector3d::Constant(1e-9),
                       Vector3d::Constant(1e-6));
    if (step % 50 != 0) continue;
    for (int axis = 0; axis < 3; ++axis) {
      C::Vector h = C::Vector::Zero();
      h[C::kPosition + axis] = 1;
      const double variance = covariance.innovation_variance(h, 1, ph);
      covariance.update(ph, variance);
    }
  }
  const C::Matrix& p = covariance.matrix();
  for (int row = 0; row < C::kStates; ++row) {
    for (int column = 0; column < row; ++column) {
      // A few roundings of the last step, of elements no larger than the two variances allow.
      const double scale = std::sqrt(p(row, row) * p(column, column));
      EXPECT_NEAR(p(row, column), p(column, row), 1e-12 * scale) << row << ' ' << column;
    }
  }
}

TEST(EstimationBound, OfAnAxisWithPositionAndVelocityMeetsTheAlgebraicSolution) {
  // White acceleration of density q seen by white positions of density r: variance of the position
  // is sqrt(2) q^(1/2) r^(3/2). No tilt error, no velocity, no bias: set their noise out of the
  // way.
  SensorFigures figures;
  figures.params.gyro_noise_rad_s.setConstant(1e-9);
  figures.params.accel_noise_m_s2.setConstant(0.5);
  figures.params.gyro_bias_initial_rad_s = 1e-9;
  figures.params.accel_bias_initial_m_s2 = 1e-9;
  figures.params.tilt_initial_rad = 1e-9;
  figures.params.gps_velocity_noise_m_s = 1e4;
  figures.params.gps_position_noise_m = 0.3;
  figures.rates.gps_hz = 50;
  const double q = 0.5 / std::sqrt(500.0);
  const double r = 0.3 / std::sqrt(50.0);
  const double expected = std::sqrt(std::sqrt(2.0) * std::sqrt(q) * std::pow(r, 1.5));
  EXPECT_NEAR(flight_bound(figures).position_m.x(), expected, 0.05 * expected);
}

}  // namespace
}  // namespace cas::fcu
