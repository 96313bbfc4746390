// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "base/config/vehicle.hpp"

namespace cas::sim {

/// A battery at a moment.
struct BatteryReading {
  double voltage_v = 0;
  double current_a = 0;
  double used_ah = 0;
  double charge = 1;  ///< 1 full, 0 empty
};

/// A battery that feeds rotors by the power of their shafts: base::BatteryParams; empty, it gives
/// nothing any more. Motors with a circuit have MotorCircuit instead.
class BatteryModel {
 public:
  BatteryModel() = default;
  explicit BatteryModel(const base::BatteryParams& params);

  /// Draws the power of the rotors' shafts over the efficiency.
  void advance(double shaft_power_w, double dt);

  double voltage_v() const { return voltage_v_; }
  double current_a() const { return current_a_; }
  double charge() const { return charge_; }  ///< 1 full, 0 empty
  double used_ah() const { return (1 - charge_) * params_.capacity_ah; }
  /// Speed that a rotor reaches over the speed it would reach on a full battery at rest.
  double speed_share() const { return voltage_v_ / params_.full_v; }
  BatteryReading reading() const { return {voltage_v_, current_a_, used_ah(), charge_}; }

 private:
  base::BatteryParams params_;
  double charge_ = 1;
  std::array<double, 2> rc_v_{};  // of the RC pairs
  double voltage_v_ = 0;
  double current_a_ = 0;
};

}  // namespace cas::sim
