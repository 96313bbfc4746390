// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/motor/motor_circuit.hpp"

#include <algorithm>
#include <cmath>

namespace cas::sim {

MotorCircuit::MotorCircuit(const base::Vehicle& vehicle)
    : rotors_(vehicle.rotors), battery_(*vehicle.battery) {}

void MotorCircuit::set_targets(std::span<const double> omega_rad_s) {
  for (std::size_t i = 0; i < rotors_.size(); ++i) {
    const base::ElectricMotor& motor = *rotors_[i].electric;
    duty_[i] =
        motor.rounded(motor.steady_duty(omega_rad_s[i], rotors_[i].params.torque_coefficient));
  }
}

void MotorCircuit::initial_states(std::span<double> battery) const {
  battery[0] = 1;
  battery[1] = battery[2] = 0;
}

MotorCircuit::Supply MotorCircuit::solve(std::span<const double> omega_rad_s,
                                         std::span<const double> battery, const Flags& off) const {
  Supply supply;
  if (battery[0] <= 0) return supply;
  const double open_v = voltage_share_ * (battery_.open_v(battery[0]) - battery[1] - battery[2]);
  const double r0 = voltage_share_ * battery_.resistance_ohm;

  // Motors below their limits draw a current linear in V; those at it are found by trying. The
  // current grows with V, so that few tries do; each motor may change sides once more.
  Flags held{};
  const auto tries = static_cast<int>(rotors_.size()) + 2;
  for (int i = 0; i < tries; ++i) {
    double fixed = open_v;
    double slope = 1;
    for (std::size_t k = 0; k < rotors_.size(); ++k) {
      if (off[k]) continue;
      const base::ElectricMotor& motor = *rotors_[k].electric;
      if (held[k]) {
        fixed -= r0 * duty_[k] * supply.motor_a[k];
      } else {
        const double duty_per_ohm = duty_[k] / motor.resistance_ohm;
        fixed += r0 * duty_per_ohm * motor.torque_constant_nm_a * omega_rad_s[k];
        slope += r0 * duty_per_ohm * duty_[k];
      }
    }
    supply.voltage_v = fixed / slope;
    bool changed = false;
    for (std::size_t k = 0; k < rotors_.size(); ++k) {
      if (off[k]) continue;
      const base::ElectricMotor& motor = *rotors_[k].electric;
      supply.motor_a[k] = motor.current_a(duty_[k] * supply.voltage_v, omega_rad_s[k]);
      const bool now = std::abs(supply.motor_a[k]) >= motor.max_current_a;
      changed = changed || now != held[k];
      held[k] = now;
    }
    if (!changed) break;
  }
  for (std::size_t k = 0; k < rotors_.size(); ++k) {
    supply.current_a += duty_[k] * supply.motor_a[k];
  }
  return supply;
}

double MotorCircuit::acceleration(std::size_t rotor, double current_a, double omega_rad_s,
                                  double load_nm) const {
  const base::Rotor& own = rotors_[rotor];
  return (own.electric->torque_nm(current_a, omega_rad_s) - load_nm) / own.params.inertia_kg_m2;
}

void MotorCircuit::battery_derivatives(const Supply& supply, std::span<const double> battery,
                                       std::span<double> battery_dot) const {
  constexpr double kSecondsPerHour = 3600;
  battery_dot[0] = -supply.current_a / (kSecondsPerHour * battery_.capacity_ah);
  for (std::size_t k = 0; k < battery_.rc_pairs.size(); ++k) {
    const base::RcPair& pair = battery_.rc_pairs[k];
    battery_dot[1 + k] =
        (pair.resistance_ohm * supply.current_a - battery[1 + k]) / pair.time_constant_s;
  }
}

void MotorCircuit::limit(std::span<double> battery) const {
  battery[0] = std::clamp(battery[0], 0.0, 1.0);
}

BatteryReading MotorCircuit::reading(const Supply& supply, std::span<const double> battery) const {
  return {.voltage_v = supply.voltage_v,
          .current_a = supply.current_a,
          .used_ah = (1 - battery[0]) * battery_.capacity_ah,
          .charge = battery[0]};
}

}  // namespace cas::sim
