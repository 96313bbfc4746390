// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/wind/dryden.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cas::sim {
namespace {

constexpr double kMetresPerFoot = 0.3048;
constexpr double kLow_ft = 1000;         // end of the low altitudes
constexpr double kHigh_ft = 2000;        // begin of the medium and high ones
constexpr double kHighLength_ft = 1750;  // of medium and high altitudes, Sect. 3.7.2.1

/// Figure 7 of MIL-F-8785C, as JSBSim (FGWinds) reads it: calm air, and the curves of 1e-2, 1e-3
/// and 1e-5.
constexpr std::array<double, 12> kHeights_ft{500,   1750,  3750,  7500,  15000, 25000,
                                             35000, 45000, 55000, 65000, 75000, 80000};
constexpr std::array<std::array<double, 12>, 4> kSigma_ft_s{
    {{},
     {6.6, 6.9, 7.4, 6.7, 4.6, 2.7, 0.4},
     {8.6, 9.6, 10.6, 10.1, 8.0, 6.6, 5.0, 4.2, 2.7},
     {15.6, 17.6, 23.0, 23.6, 22.1, 20.0, 16.0, 15.1, 12.1, 7.9, 6.2, 5.1}}};

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

/// First-order lag of an input that goes from `before` to `now` in a straight line.
/// @param theta  step over time constant
double lag(double value, double before, double now, double theta) {
  const double share = -std::expm1(-theta);
  return value + share * (before - value) + (1 - share / theta) * (now - before);
}

}  // namespace

DrydenScales DrydenScales::at(double w20_m_s, double height_m) {
  const double height_ft = height_m / kMetresPerFoot;
  const double h = std::clamp(height_ft, 10.0, kLow_ft);  // ft, as the formulas
  const double shape = 0.177 + 0.000823 * h;
  const double sigma_w = 0.1 * w20_m_s;
  DrydenScales scales{.length_horizontal_m = h / std::pow(shape, 1.2) * kMetresPerFoot,
                      .length_vertical_m = h * kMetresPerFoot,
                      .sigma_horizontal_m_s = sigma_w / std::pow(shape, 0.4),
                      .sigma_vertical_m_s = sigma_w};
  if (height_ft <= kLow_ft) return scales;

  const double share = std::min(1.0, (height_ft - kLow_ft) / (kHigh_ft - kLow_ft));
  const double sigma =
      high_altitude_sigma_m_s(w20_m_s, std::max(height_ft, kHigh_ft) * kMetresPerFoot);
  const auto approach = [share](double& value, double end) { value += share * (end - value); };
  approach(scales.length_horizontal_m, kHighLength_ft * kMetresPerFoot);
  approach(scales.length_vertical_m, kHighLength_ft * kMetresPerFoot);
  approach(scales.sigma_horizontal_m_s, sigma);
  approach(scales.sigma_vertical_m_s, sigma);
  return scales;
}

double high_altitude_sigma_m_s(double w20_m_s, double height_m) {
  const double severity =
      w20_m_s / (15 * kMetresPerSecondPerKnot);  // 1, 2, 3: light, moderate, severe
  const auto curve = std::clamp(static_cast<std::size_t>(severity), std::size_t{0}, std::size_t{2});
  const double height_ft = height_m / kMetresPerFoot;
  std::size_t above = 1;
  while (above + 1 < kHeights_ft.size() && kHeights_ft[above] < height_ft) ++above;
  const double along = std::clamp(
      (height_ft - kHeights_ft[above - 1]) / (kHeights_ft[above] - kHeights_ft[above - 1]), 0.0,
      1.0);
  const auto on = [&](std::size_t row) {
    return kSigma_ft_s[row][above - 1] +
           along * (kSigma_ft_s[row][above] - kSigma_ft_s[row][above - 1]);
  };
  const double below = on(curve);
  return kMetresPerFoot *
         (below + (severity - static_cast<double>(curve)) * (on(curve + 1) - below));
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

DrydenRates::DrydenRates(double span_m, std::uint64_t seed)
    : span_m_(span_m), random_(seed), p_(random_()) {}

double DrydenRates::sigma_p(const DrydenScales& scales, double span_m) {
  const double length = scales.length_vertical_m;
  return scales.sigma_vertical_m_s * M_PI * std::sqrt(0.1 / (span_m * length)) *
         std::pow(M_PI * length / (4 * span_m), 1.0 / 6.0);
}

Eigen::Matrix3d DrydenRates::advance(const DrydenScales& scales, double speed_m_s, double dt,
                                     const Eigen::Vector3d& uvw) {
  const double time_w = 4 * span_m_ / (M_PI * speed_m_s);
  const double time_v = 3 * span_m_ / (M_PI * speed_m_s);
  if (!begun_) {
    uvw_ = uvw;
    v_ = uvw[1];
    w_ = uvw[2];
    begun_ = true;
  }
  // s / (1 + T s) is what the lag has still to do, over T.
  v_ = lag(v_, uvw_[1], uvw[1], dt / time_v);
  w_ = lag(w_, uvw_[2], uvw[2], dt / time_w);
  uvw_ = uvw;
  p_ = std::exp(-dt / time_w) * p_ + std::sqrt(-std::expm1(-2 * dt / time_w)) * random_();

  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
  gradient(1, 0) = -(uvw[1] - v_) / (time_v * speed_m_s);
  gradient(2, 0) = -(uvw[2] - w_) / (time_w * speed_m_s);
  gradient(2, 1) = sigma_p(scales, span_m_) * p_;
  return gradient;
}

}  // namespace cas::sim
