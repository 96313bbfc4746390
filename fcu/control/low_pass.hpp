// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace cas::fcu {

/// Second-order Butterworth low-pass on three axes (bilinear transform with prewarping).
class LowPass {
 public:
  /// @param cutoff_hz  0, or half the sample rate and above, switches the filter off
  void configure(double sample_rate_hz, double cutoff_hz) {
    if (sample_rate_hz == rate_hz_ && cutoff_hz == cutoff_hz_) return;
    rate_hz_ = sample_rate_hz;
    cutoff_hz_ = cutoff_hz;
    active_ = cutoff_hz > 0 && cutoff_hz < 0.5 * sample_rate_hz;
    if (!active_) return;
    const double k = std::tan(M_PI * cutoff_hz / sample_rate_hz);
    const double c = 1 + std::sqrt(2.0) * k + k * k;
    b0_ = k * k / c;
    a1_ = 2 * (k * k - 1) / c;
    a2_ = (1 - std::sqrt(2.0) * k + k * k) / c;
  }

  Eigen::Vector3d update(const Eigen::Vector3d& x) {
    if (!started_) reset(x);
    const Eigen::Vector3d y = b0_ * (x + 2 * x1_ + x2_) - a1_ * y1_ - a2_ * y2_;
    x2_ = x1_;
    x1_ = x;
    y2_ = y1_;
    y1_ = active_ ? y : x;
    return y1_;
  }

  void reset(const Eigen::Vector3d& x) {
    x1_ = x2_ = y1_ = y2_ = x;
    started_ = true;
  }

 private:
  double rate_hz_ = 0, cutoff_hz_ = -1;
  double b0_ = 0, a1_ = 0, a2_ = 0;
  bool active_ = false, started_ = false;
  Eigen::Vector3d x1_ = Eigen::Vector3d::Zero(), x2_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d y1_ = Eigen::Vector3d::Zero(), y2_ = Eigen::Vector3d::Zero();
};

}  // namespace cas::fcu
