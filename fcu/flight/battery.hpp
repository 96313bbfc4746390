// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

namespace cas::fcu {

/// The battery that a HIL controller makes up, as PX4's does: full at start, falling linearly while
/// armed, never below a floor.
class Battery {
 public:
  struct Params {
    double drain_s = 900;  ///< from full to empty while armed
    double floor = 0.5;    ///< 0..1, where it stops
    int cells = 4;
  };

  void set_params(const Params& params) { params_ = params; }
  /// @param dt  s since the last call
  void update(bool armed, double dt) {
    if (!armed) return;
    if (remaining_ > params_.floor) {
      remaining_ = std::max(params_.floor, remaining_ - dt / params_.drain_s);
    }
    consumed_mah_ += kCurrent_a * dt / 3.6;
  }

  /// 0..1 of full
  double remaining() const { return remaining_; }
  double voltage_v() const {
    return params_.cells * (kEmptyCell_v + (kFullCell_v - kEmptyCell_v) * remaining_);
  }
  double current_a(bool armed) const { return armed ? kCurrent_a : 0.2; }
  double consumed_mah() const { return consumed_mah_; }

 private:
  static constexpr double kFullCell_v = 4.05;  // PX4's BAT1_V_CHARGED
  static constexpr double kEmptyCell_v = 3.6;  // PX4's BAT1_V_EMPTY
  static constexpr double kCurrent_a = 10;     // as PX4 reports in HIL
  Params params_;
  double remaining_ = 1;
  double consumed_mah_ = 0;
};

}  // namespace cas::fcu
