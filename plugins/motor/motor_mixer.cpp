// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/motor/motor_mixer.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace cas::sim {
namespace {

/// One value of a command; a missing or non-finite one counts as 0.
double value_of(const ActuatorValues& values, Eigen::Index index) {
  if (index >= values.size() || !std::isfinite(values[index])) return 0.0;
  return values[index];
}

/// Rows U1..U4 of the effectiveness matrix, in the axes of D.
Eigen::Matrix<double, 4, Eigen::Dynamic> four_rows(const base::Effectiveness& all) {
  Eigen::Matrix<double, 4, Eigen::Dynamic> rows(4, all.cols());
  rows << all.row(2), all.row(3), -all.row(4), -all.row(5);
  return rows;
}

}  // namespace

MotorMixer::MotorMixer(const base::Vehicle& vehicle) : rotors_(vehicle.rotors) {
  has_servos_ =
      std::ranges::any_of(rotors_, [](const base::Rotor& rotor) { return rotor.tilt.has_value(); });
  if (vehicle.rotor_count() != 4 || has_servos_) {
    const Eigen::Matrix<double, 4, Eigen::Dynamic> mixing = four_rows(vehicle.effectiveness());
    pseudo_inverse_ = mixing.completeOrthogonalDecomposition().pseudoInverse();
    return;
  }
  inverse_ = Eigen::FullPivLU<Eigen::Matrix4d>(vehicle.mixing_matrix()).inverse();
}

base::RotorVector MotorMixer::targets(const MotorCommand& command) const {
  if (!command.armed) return base::RotorVector::Zero(static_cast<Eigen::Index>(rotors_.size()));
  if (command.kind == MotorCommand::Kind::kMotorOutputs) return from_motor_outputs(command.values);
  return from_control_inputs({value_of(command.values, 0), value_of(command.values, 1),
                              value_of(command.values, 2), value_of(command.values, 3)});
}

std::optional<int> MotorMixer::refused_reverse(const MotorCommand& command) const {
  constexpr double kNoise = 1e-3;  // of a full output: rounding on the wire
  if (!command.armed || command.kind != MotorCommand::Kind::kMotorOutputs) return std::nullopt;
  for (std::size_t i = 0; i < rotors_.size(); ++i) {
    if (rotors_[i].params.reversible) continue;
    if (value_of(command.values, rotors_[i].output) < -kNoise) return static_cast<int>(i);
  }
  return std::nullopt;
}

base::RotorVector MotorMixer::tilts(const MotorCommand& command) const {
  base::RotorVector tilts = base::RotorVector::Zero(static_cast<Eigen::Index>(rotors_.size()));
  if (!command.armed || command.kind != MotorCommand::Kind::kMotorOutputs) return tilts;
  for (std::size_t i = 0; i < rotors_.size(); ++i) {
    if (!rotors_[i].tilt) continue;
    const base::TiltServo& servo = *rotors_[i].tilt;
    tilts[static_cast<Eigen::Index>(i)] = servo.angle_rad(value_of(command.values, servo.output));
  }
  return tilts;
}

base::RotorVector MotorMixer::from_control_inputs(const Eigen::Vector4d& inputs) const {
  base::RotorVector omega;  // squared
  if (pseudo_inverse_.rows() > 0) {
    omega = pseudo_inverse_ * inputs;
  } else {
    omega = inverse_ * inputs;
  }
  for (std::size_t i = 0; i < rotors_.size(); ++i) {
    double& value = omega[static_cast<Eigen::Index>(i)];
    const base::RotorParams& params = rotors_[i].params;
    const double high = params.omega_max_rad_s * params.omega_max_rad_s;
    const double low =
        params.reversible ? -high : params.omega_idle_rad_s * params.omega_idle_rad_s;
    value = std::min(std::max(value, low), high);
    value = std::copysign(std::sqrt(std::abs(value)), value);
  }
  return omega;
}

base::RotorVector MotorMixer::from_motor_outputs(const ActuatorValues& outputs) const {
  base::RotorVector omega(static_cast<Eigen::Index>(rotors_.size()));
  for (std::size_t i = 0; i < rotors_.size(); ++i) {
    const base::RotorParams& params = rotors_[i].params;
    const double least = params.reversible ? -1.0 : 0.0;
    const double u = std::clamp(value_of(outputs, rotors_[i].output), least, 1.0);
    omega[static_cast<Eigen::Index>(i)] = rotors_[i].speed_at(u);
  }
  return omega;
}

}  // namespace cas::sim
