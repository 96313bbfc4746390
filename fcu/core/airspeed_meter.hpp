// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/earth/atmosphere.hpp"
#include "base/time/clock.hpp"
#include "fcu/control/airspeed.hpp"

namespace cas::fcu {

/// Airspeed from a pitot tube, or the speed over ground where the tube has been silent.
class AirspeedMeter {
 public:
  /// A difference of pressures (Pa); one that is not finite is left out.
  void on_sample(double difference_pa, base::RunTime now) {
    if (!std::isfinite(difference_pa)) return;
    constexpr double kSmoothing_s = 0.05;
    const double dt = last_ ? std::max(base::to_seconds(now - *last_), 0.0) : 0.0;
    const double share = last_ ? dt / (kSmoothing_s + dt) : 1.0;
    difference_pa_ += share * (difference_pa - difference_pa_);
    last_ = now;
  }
  /// The air's static pressure (Pa) and temperature (degC), for the true airspeed.
  void set_air(double pressure_pa, double temperature_degc) {
    constexpr double kGasConstant_J_kg_K = 287.05287;  // of dry air, [ISO 2533]
    const double density =
        pressure_pa / (kGasConstant_J_kg_K * (temperature_degc + base::kZeroCelsius_K));
    if (density > 0.1 && density < 2) true_per_equivalent_ = std::sqrt(kDensity / density);
  }
  bool alive(base::RunTime now) const {
    constexpr double kSilent_s = 1;
    return last_ && base::to_seconds(now - *last_) < kSilent_s;
  }
  /// @param ground_speed_m_s  stands in for the true airspeed where the tube is silent
  /// @param use_tube          whether the tube counts at all
  Airspeed read(double ground_speed_m_s, bool use_tube, base::RunTime now) const {
    if (!use_tube || !alive(now)) {
      return {ground_speed_m_s / true_per_equivalent_, ground_speed_m_s, false};
    }
    const double equivalent = std::sqrt(std::max(0.0, 2 * difference_pa_ / kDensity));
    return {equivalent, equivalent * true_per_equivalent_, true};
  }

 private:
  static constexpr double kDensity = 1.225;  // kg/m^3 at sea level, [ISO 2533]
  double difference_pa_ = 0;
  double true_per_equivalent_ = 1;
  std::optional<base::RunTime> last_;
};

}  // namespace cas::fcu
