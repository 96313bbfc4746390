// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/motor/battery_model.hpp"

#include <algorithm>
#include <cmath>

namespace cas::sim {

BatteryModel::BatteryModel(const base::BatteryParams& params)
    : params_(params), voltage_v_(params.full_v) {}

void BatteryModel::advance(double shaft_power_w, double dt) {
  if (charge_ <= 0) {
    voltage_v_ = current_a_ = 0;
    return;
  }
  constexpr double kSecondsPerHour = 3600;
  const double open_v = params_.open_v(charge_) - rc_v_[0] - rc_v_[1];
  const double power_w = shaft_power_w / params_.efficiency;
  const double r = params_.resistance_ohm;

  // V I = P with V = V0 - R I; beyond the most it can give, the battery gives half its voltage.
  const double root = std::sqrt(std::max(0.0, open_v * open_v - 4.0 * r * power_w));
  voltage_v_ = 0.5 * (open_v + root);
  current_a_ = voltage_v_ > 0 ? power_w / voltage_v_ : 0.0;
  const double used_ah = current_a_ * dt / kSecondsPerHour;
  charge_ = std::max(0.0, charge_ - used_ah / params_.capacity_ah);
  for (std::size_t k = 0; k < rc_v_.size(); ++k) {
    const base::RcPair& pair = params_.rc_pairs[k];
    rc_v_[k] +=
        (pair.resistance_ohm * current_a_ - rc_v_[k]) * -std::expm1(-dt / pair.time_constant_s);
  }
}

}  // namespace cas::sim
