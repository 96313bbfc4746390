// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "base/random.hpp"

namespace cas::sim {

/// Three independent normal deviates, drawn in the order x, y, z.
inline Eigen::Vector3d normal3(base::NormalRandom& random) {
  const double x = random();
  const double y = random();
  const double z = random();
  return {x, y, z};
}

/// A slow drift, per axis: x' = -x / tau + walk * n with white noise n of density 1.
template <int N>
struct GaussMarkovParams {
  using Vector = Eigen::Matrix<double, N, 1>;
  Vector walk = Vector::Zero();  ///< density of the driving noise, unit / sqrt(s)
  double time_constant_s = 0;    ///< tau; 0: a random walk that never decays

  /// The process with the standing deviation `stddev` (its walk is stddev * sqrt(2 / tau)).
  static GaussMarkovParams standing(const Vector& stddev, double time_constant_s) {
    return {stddev * std::sqrt(2.0 / time_constant_s), time_constant_s};
  }
  /// Standing deviation; zero for a pure random walk, which has none.
  Vector stddev() const { return walk * std::sqrt(time_constant_s / 2.0); }
};

/// Steps a Gauss-Markov process by its exact solution, so that its statistics at any time do not
/// depend on the step:
///   x <- e^(-dt/tau) x + walk sqrt(tau/2 (1 - e^(-2 dt/tau))) n
///   x <- x + walk sqrt(dt) n                                        where tau = 0
template <int N>
class GaussMarkov {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  GaussMarkov() = default;
  /// @param dt_s  time between two calls of advance()
  GaussMarkov(const GaussMarkovParams<N>& params, double dt_s) : params_(params) {
    const double tau = params.time_constant_s;
    if (tau > 0) {
      decay_ = std::exp(-dt_s / tau);
      kick_ = params.walk * std::sqrt(-tau / 2.0 * std::expm1(-2.0 * dt_s / tau));
    } else {
      kick_ = params.walk * std::sqrt(dt_s);
    }
    active_ = !params.walk.isZero(0.0);
  }

  /// Draws the present value from the standing distribution (zero for a pure random walk).
  void settle(base::NormalRandom& random) {
    if (active_) value_ = params_.stddev().cwiseProduct(normal(random));
  }
  const Vector& advance(base::NormalRandom& random) {
    if (active_) value_ = decay_ * value_ + kick_.cwiseProduct(normal(random));
    return value_;
  }
  const Vector& value() const { return value_; }

 private:
  static Vector normal(base::NormalRandom& random) {
    Vector deviates;
    for (int i = 0; i < N; ++i) deviates[i] = random();
    return deviates;
  }

  GaussMarkovParams<N> params_;
  double decay_ = 1.0;
  Vector kick_ = Vector::Zero();
  Vector value_ = Vector::Zero();
  bool active_ = false;
};

}  // namespace cas::sim
