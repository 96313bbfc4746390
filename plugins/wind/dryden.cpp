// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/wind/dryden.hpp"

#include <algorithm>
#include <cmath>

namespace cas::sim {
namespace {

constexpr double kMetresPerFoot = 0.3048;

/// Covariance that white noise adds to (y1, y2) over a step, by theta = dt / tau.
///
/// For y1' = -y1 + sqrt(2) n, y2' = y1 - y2: Q11 = 1 - e^-2t, Q12 = 1/2 - e^-2t (t + 1/2),
/// Q22 = 1/2 - e^-2t (t^2 + t + 1/2); short steps by series, where the differences cancel.
struct StepCovariance {
  double q11, q12, q22;

  explicit StepCovariance(double theta) {
    constexpr double kShort = 0.01;
    const double t = theta;
    q11 = -std::expm1(-2.0 * t);
    if (t < kShort) {
      q12 = t * t * (1.0 + t * (-4.0 / 3.0 + t));
      q22 = t * t * t * (2.0 / 3.0 + t * (-1.0 + t * 0.8));
    } else {
      const double decay = std::exp(-2.0 * t);
      q12 = 0.5 - decay * (t + 0.5);
      q22 = 0.5 - decay * (t * t + t + 0.5);
    }
  }
};

}  // namespace

DrydenScales DrydenScales::at(double w20_m_s, double height_m) {
  const double h = std::clamp(height_m / kMetresPerFoot, 10.0, 1000.0);  // ft, as the formulas
  const double shape = 0.177 + 0.000823 * h;
  const double sigma_w = 0.1 * w20_m_s;
  return {.length_horizontal_m = h / std::pow(shape, 1.2) * kMetresPerFoot,
          .length_vertical_m = h * kMetresPerFoot,
          .sigma_horizontal_m_s = sigma_w / std::pow(shape, 0.4),
          .sigma_vertical_m_s = sigma_w};
}

void DrydenLateral::settle(base::NormalRandom& random) {
  // Standing covariance of (y1, y2): 1, 1/2, 1/2.
  y1_ = random();
  y2_ = 0.5 * y1_ + 0.5 * random();
}

double DrydenLateral::advance(double theta, base::NormalRandom& random) {
  const double decay = std::exp(-theta);
  const StepCovariance q(theta);
  const double l11 = std::sqrt(q.q11);
  const double l21 = q.q12 / l11;
  const double l22 = std::sqrt(std::max(0.0, q.q22 - l21 * l21));
  const double n1 = random();
  const double n2 = random();
  const double before = y1_;
  y1_ = decay * before + l11 * n1;
  y2_ = decay * (theta * before + y2_) + l21 * n1 + l22 * n2;

  // (1 + c tau s) / (1 + tau s)^2 = c / (1 + tau s) + (1 - c) / (1 + tau s)^2, of variance 2 here.
  const double c = std::sqrt(3.0);
  return (c * y1_ + (1.0 - c) * y2_) / std::sqrt(2.0);
}

Dryden::Dryden(std::uint64_t seed) : random_(seed), u_(random_()) {
  v_.settle(random_);
  w_.settle(random_);
}

Eigen::Vector3d Dryden::advance(const DrydenScales& scales, double speed_m_s, double dt) {
  const double theta_h = speed_m_s * dt / scales.length_horizontal_m;
  const double theta_w = speed_m_s * dt / scales.length_vertical_m;
  u_ = std::exp(-theta_h) * u_ + std::sqrt(-std::expm1(-2.0 * theta_h)) * random_();
  const double v = v_.advance(theta_h, random_);
  const double w = w_.advance(theta_w, random_);
  return {scales.sigma_horizontal_m_s * u_, scales.sigma_horizontal_m_s * v,
          scales.sigma_vertical_m_s * w};
}

}  // namespace cas::sim
