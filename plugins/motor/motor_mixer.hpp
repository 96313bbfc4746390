// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "base/config/vehicle.hpp"
#include "libsim/api/messages.hpp"

namespace cas::sim {

/// Turns actuator commands into the rotor speeds and tilts that are asked for.
///
/// Control inputs go through the inverse of [HILS] Eq. (3), with omega^2 held in
/// [idle^2, max^2]; with more or fewer than four rotors through the pseudo-inverse. Motor outputs u
/// in 0..1 give idle + u (max - idle), the law of PX4's simulated iris (100 + 1000 u, at most
/// 1100 rad/s), or what a circuit makes of that duty, and in -1..0 of a `reversible` rotor u max;
/// servo outputs in -1..1 give tilts. A disarmed vehicle's rotors are asked to stop, its servos to
/// stand upright.
class MotorMixer {
 public:
  MotorMixer() = default;
  explicit MotorMixer(const base::Vehicle& vehicle);

  /// @return target speeds of the rotors, rad/s; numbers that are not finite count as 0
  base::RotorVector targets(const MotorCommand& command) const;
  /// @return target tilts, rad, one for each rotor; 0 where it has no servo
  base::RotorVector tilts(const MotorCommand& command) const;
  /// The first rotor that is to turn the other way and is not `reversible`: it stays at idle.
  std::optional<int> refused_reverse(const MotorCommand& command) const;
  bool has_servos() const { return has_servos_; }

 private:
  base::RotorVector from_control_inputs(const Eigen::Vector4d& inputs) const;
  base::RotorVector from_motor_outputs(const ActuatorValues& outputs) const;

  std::vector<base::Rotor> rotors_;
  bool has_servos_ = false;
  Eigen::Matrix4d inverse_ = Eigen::Matrix4d::Zero();  // of four rotors
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::ColMajor, base::kMaxRotors, 4> pseudo_inverse_;
};

}  // namespace cas::sim
