// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "fcu/control/control_params.hpp"
#include "fcu/control/pid.hpp"

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

/// Body-rate loop: PID with feed-forward, derivative on the filtered measurement. ControlCascade
/// has it innermost; the environment of hils runs it alone for actions that are rates.
class RateController {
 public:
  void set_params(const ControlParams& params);
  void reset() {
    for (Pid& pid : pid_) pid.reset();
  }

  /// Takes one gyro sample (every sample, also between control steps).
  void on_rates(const Eigen::Vector3d& w_D, double dt);

  /// @param saturation  of the torques about Dx, Dy, Dz at the last step
  /// @return torques about Dx, Dy, Dz as fractions of full scale
  Eigen::Vector3d update(const Eigen::Vector3d& w_setpoint_D,
                         const std::array<Saturation, 3>& saturation, double dt);

 private:
  std::array<Pid, 3> pid_;
  Eigen::Vector3d feed_forward_ = Eigen::Vector3d::Zero();
  double gyro_cutoff_hz_ = 60;
  double dgyro_cutoff_hz_ = 30;
  double sample_dt_ = 0.002;
  LowPass gyro_filter_;
  LowPass dgyro_filter_;
  Eigen::Vector3d w_D_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_dot_D_ = Eigen::Vector3d::Zero();
  bool started_ = false;
};

}  // namespace cas::fcu
