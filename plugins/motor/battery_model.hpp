// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/config/vehicle.hpp"

namespace cas::sim {

/// A battery that feeds the rotors: open-circuit voltage falls linearly with the charge, the inner
/// resistance takes the rest; empty, it gives nothing any more. Temperature and recovery after load
/// are not modelled.
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

 private:
  base::BatteryParams params_;
  double charge_ = 1;
  double voltage_v_ = 0;
  double current_a_ = 0;
};

}  // namespace cas::sim
