// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/config/vehicle.hpp"
#include "plugins/motor/battery_model.hpp"

namespace cas::sim {

/// The motors' circuits on one battery: V = E - V_1 - V_2 - R_0 sum d_k i_k with i_k of
/// base::ElectricMotor, solved exactly, motors at their current limit included. Charge and the
/// voltages V_1, V_2 of the RC pairs are states of the integrator. An empty battery is switched
/// off: no current flows.
class MotorCircuit {
 public:
  /// Charge 0..1, V_1, V_2.
  static constexpr std::size_t kStates = 3;
  static constexpr std::size_t kMost = base::kMaxRotors;
  using Flags = std::array<bool, kMost>;

  /// Terminal voltage and current of the battery, currents of the motors.
  struct Supply {
    double voltage_v = 0;
    double current_a = 0;
    std::array<double, kMost> motor_a{};
  };

  /// @param vehicle  with a battery, its rotors all with a circuit
  explicit MotorCircuit(const base::Vehicle& vehicle);

  /// Duty for each speed asked for, in the controllers' steps.
  void set_targets(std::span<const double> omega_rad_s);
  /// Share of the battery's voltage that is left, 0..1.
  void set_voltage_share(double share) { voltage_share_ = share; }

  void initial_states(std::span<double> battery) const;
  /// @param off  motors that are switched off
  Supply solve(std::span<const double> omega_rad_s, std::span<const double> battery,
               const Flags& off) const;
  /// dw/dt of a rotor, rad/s^2.
  /// @param load_nm  against its turning
  double acceleration(std::size_t rotor, double current_a, double omega_rad_s,
                      double load_nm) const;
  void battery_derivatives(const Supply& supply, std::span<const double> battery,
                           std::span<double> battery_dot) const;
  void limit(std::span<double> battery) const;
  BatteryReading reading(const Supply& supply, std::span<const double> battery) const;

 private:
  std::vector<base::Rotor> rotors_;
  base::BatteryParams battery_;
  std::array<double, kMost> duty_{};
  double voltage_share_ = 1;
};

}  // namespace cas::sim
