// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "fcu/control/control_params.hpp"
#include "fcu/control/pid.hpp"
#include "fcu/control/setpoint.hpp"

namespace cas::fcu {

/// Vertical position and velocity loops of [HILS] Fig. 8, on the z (down) components: P on
/// position, PID with feed-forward on velocity.
class AltitudeController {
 public:
  void set_params(const ControlParams& params);
  void reset(double integral = 0) { velocity_.reset(integral); }

  /// @param saturation  `up`: the thrust can give no more downward acceleration; `down`: no more
  ///                    upward acceleration (directions of z, which points down)
  /// @return wanted acceleration along Nz (down), m/s^2
  double update(const TrajectorySetpoint& setpoint, double z, double vz, double az,
                Saturation saturation, double dt);

 private:
  double p_ = 1;
  double up_limit_ = 1;
  double down_limit_ = 1;
  Pid velocity_;
};

}  // namespace cas::fcu
