// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "fcu/control/control_params.hpp"
#include "fcu/control/pid.hpp"
#include "fcu/control/setpoint.hpp"

namespace cas::fcu {

/// Horizontal position and velocity loops of [HILS] Fig. 8: P on position, PID with feed-forward on
/// velocity. Works on the x and y components of what it is given.
class PositionController {
 public:
  void set_params(const ControlParams& params);
  void reset() {
    for (Pid& pid : velocity_) pid.reset();
  }

  /// @param a_N          measured acceleration (the derivative of the velocity), m/s^2
  /// @param saturated_N  the direction in N in which the last answer could not be followed, or zero
  /// @return wanted horizontal acceleration, m/s^2
  Eigen::Vector2d update(const TrajectorySetpoint& setpoint, const Eigen::Vector3d& p_N,
                         const Eigen::Vector3d& v_N, const Eigen::Vector3d& a_N,
                         const Eigen::Vector2d& saturated_N, double dt);

 private:
  double p_ = 1;
  double velocity_limit_ = 1;
  double acceleration_limit_ = 1;
  Pid velocity_[2];
};

}  // namespace cas::fcu
