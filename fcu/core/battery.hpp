// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>

#include "fcu/params/settings.hpp"

namespace cas::fcu {

/// The controller's battery state, from the simulator's BATTERY_STATUS. Until the first one it is
/// made up, as PX4 does in HIL: full at start, falling linearly while armed, never below a floor.
/// If BATTERY_STATUS stops, the state is unknown.
class Battery {
 public:
  /// Measurement of a power module.
  struct Reading {
    double voltage_v = 0;
    int cells = 1;            ///< cells of the voltage; 1: the pack as a whole
    double current_a = 0;     ///< negative: unknown
    double remaining = 0;     ///< 0..1 of full
    double consumed_mah = 0;  ///< negative: unknown
  };

  void set_params(const BatteryParams& params) { params_ = params; }
  /// @param dt  s since the last call
  void update(bool armed, double dt) {
    age_s_ += dt;
    if (!armed || measured_) return;
    const double floor = params_.floor_percent / 100;
    if (remaining_ > floor) remaining_ = std::max(floor, remaining_ - dt / params_.drain_s);
    consumed_mah_ += kCurrent_a * dt / 3.6;
  }

  /// From now on this one counts.
  void measure(const Reading& reading) {
    measured_ = reading;
    age_s_ = 0;
  }
  /// Back to the one that is made up: another simulation may measure none.
  void forget_measured() { measured_.reset(); }

  /// Nothing while it is unknown.
  std::optional<Reading> reading(bool armed) const {
    if (measured_) return unknown() ? std::nullopt : measured_;
    const double cell_v = kEmptyCell_v + (kFullCell_v - kEmptyCell_v) * remaining_;
    return Reading{.voltage_v = params_.cells * cell_v,
                   .cells = params_.cells,
                   .current_a = armed ? kCurrent_a : 0.2,
                   .remaining = remaining_,
                   .consumed_mah = consumed_mah_};
  }
  /// 0..1 of full; nullopt while it is unknown.
  std::optional<double> remaining() const {
    if (unknown()) return std::nullopt;
    return measured_ ? measured_->remaining : remaining_;
  }

 private:
  /// PX4 calls a battery unhealthy after this long without news (batteryCheck.cpp).
  static constexpr double kPatience_s = 5;
  bool unknown() const { return measured_ && age_s_ > kPatience_s; }

  static constexpr double kFullCell_v = 4.05;  // PX4's BAT1_V_CHARGED
  static constexpr double kEmptyCell_v = 3.6;  // PX4's BAT1_V_EMPTY
  static constexpr double kCurrent_a = 10;     // as PX4 reports in HIL
  BatteryParams params_;
  double remaining_ = 1;
  double consumed_mah_ = 0;
  std::optional<Reading> measured_;
  double age_s_ = 0;  // of measured_
};

}  // namespace cas::fcu
