// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/config/vehicle.hpp"
#include "libsim/api/messages.hpp"

namespace cas::sim {

/// Turns actuator commands into the rotor speeds that are asked for.
///
/// Control inputs go through the inverse of [HILS] Eq. (3), with omega^2 held in
/// [idle^2, max^2]. Motor outputs u in 0..1 give idle + u (max - idle), the law of PX4's simulated
/// iris (100 + 1000 u, at most 1100 rad/s). A disarmed vehicle's rotors are asked to stop.
class MotorMixer {
 public:
  MotorMixer() = default;
  explicit MotorMixer(const base::Vehicle& vehicle);

  /// @return target speeds of rotors 1..4, rad/s; numbers that are not finite count as 0
  Eigen::Vector4d targets(const MotorCommand& command) const;

 private:
  Eigen::Vector4d from_control_inputs(const Eigen::Vector4d& inputs) const;
  Eigen::Vector4d from_motor_outputs(const Eigen::Vector4d& outputs) const;

  Eigen::Matrix4d inverse_ = Eigen::Matrix4d::Zero();
  double omega_idle_ = 0;
  double omega_max_ = 0;
};

}  // namespace cas::sim
