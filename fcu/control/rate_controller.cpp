// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/rate_controller.hpp"

#include <algorithm>
#include <cmath>

namespace cas::fcu {

using Eigen::Vector3d;

void RateController::set_params(const ControlParams& params) {
  pid_[0].set_gains(params.rate_roll);
  pid_[1].set_gains(params.rate_pitch);
  pid_[2].set_gains(params.rate_yaw);
  feed_forward_ = params.rate_feed_forward;
  gyro_cutoff_hz_ = params.gyro_cutoff_hz;
  dgyro_cutoff_hz_ = params.dgyro_cutoff_hz;
}

void RateController::on_rates(const Vector3d& w_D, double dt) {
  if (dt <= 0 || !w_D.allFinite()) return;
  // The filters are designed for the sensor's usual spacing: a lost sample must not redesign them.
  sample_dt_ += 0.01 * (std::clamp(dt, 5e-4, 0.02) - sample_dt_);
  const double rate_hz = std::round(1.0 / sample_dt_);
  gyro_filter_.configure(rate_hz, gyro_cutoff_hz_);
  dgyro_filter_.configure(rate_hz, dgyro_cutoff_hz_);
  const Vector3d before = w_D_;
  w_D_ = gyro_filter_.update(w_D);
  w_dot_D_ = dgyro_filter_.update(started_ ? Vector3d((w_D_ - before) / dt) : Vector3d::Zero());
  started_ = true;
}

Vector3d RateController::update(const Vector3d& w_setpoint_D,
                                const std::array<Saturation, 3>& saturation, double dt) {
  Vector3d torque;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    torque[axis] =
        pid_[i].update(w_setpoint_D[axis] - w_D_[axis], w_dot_D_[axis], dt, saturation[i]) +
        feed_forward_[axis] * w_setpoint_D[axis];
  }
  return torque.cwiseMax(-1.0).cwiseMin(1.0);
}

}  // namespace cas::fcu
