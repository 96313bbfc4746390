// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/motor/motor_mixer.hpp"

#include <Eigen/LU>
#include <cmath>

#include "base/error.hpp"

namespace cas::sim {

MotorMixer::MotorMixer(const base::Vehicle& vehicle)
    : omega_idle_(vehicle.rotor.omega_idle_rad_s), omega_max_(vehicle.rotor.omega_max_rad_s) {
  const Eigen::FullPivLU<Eigen::Matrix4d> mixing(vehicle.mixing_matrix());
  if (!mixing.isInvertible()) {
    throw base::ConfigError("vehicle '" + vehicle.name +
                            "': its rotors cannot give thrust and three moments independently");
  }
  inverse_ = mixing.inverse();
}

Eigen::Vector4d MotorMixer::targets(const MotorCommand& command) const {
  if (!command.armed) return Eigen::Vector4d::Zero();
  const auto finite = [](double value) { return std::isfinite(value) ? value : 0.0; };
  const Eigen::Vector4d values = command.values.unaryExpr(finite);
  return command.kind == MotorCommand::Kind::kControlInputs ? from_control_inputs(values)
                                                            : from_motor_outputs(values);
}

Eigen::Vector4d MotorMixer::from_control_inputs(const Eigen::Vector4d& inputs) const {
  const Eigen::Vector4d omega_squared = inverse_ * inputs;
  return omega_squared.cwiseMax(omega_idle_ * omega_idle_)
      .cwiseMin(omega_max_ * omega_max_)
      .cwiseSqrt();
}

Eigen::Vector4d MotorMixer::from_motor_outputs(const Eigen::Vector4d& outputs) const {
  const Eigen::Array4d u = outputs.array().max(0.0).min(1.0);
  return (omega_idle_ + u * (omega_max_ - omega_idle_)).matrix();
}

}  // namespace cas::sim
