// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>

#include "fcu/control/control_params.hpp"
#include "fcu/control/low_pass.hpp"
#include "fcu/control/pid.hpp"

namespace cas::fcu {

/// Body-rate loop: PID with feed-forward, derivative on the filtered measurement.
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

  /// Filtered rates, rad/s.
  const Eigen::Vector3d& rates() const { return w_D_; }

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
