// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/total_energy.hpp"

#include <algorithm>

#include "base/earth/gravity.hpp"

namespace cas::fcu {
namespace {

constexpr double kGravityOfEnergy_m_s2 = base::kStandardGravity_m_s2;
constexpr double kSlowestAir_m_s = 3;
constexpr double kTooSlow = 0.9;  // of the least airspeed: below it speed comes before height
constexpr double kMostTrim_rad = 0.15;

}  // namespace

/// @param rate   wanted rate of energy
/// @param error  wanted minus measured
double TotalEnergy::throttle_for(double rate, double error, double v, double dt) {
  const WingParams& p = params_;
  // Straight lines through the trim to what the ends of the throttle give.
  const double up = (p.throttle_max - p.throttle_trim) / (p.climb_max_m_s / v);
  const double down = (p.throttle_trim - p.throttle_min) / (p.sink_min_m_s / v);
  const double slope = rate > 0 ? up : down;
  const double predicted = p.throttle_trim + slope * rate + up * p.throttle_damping * error;
  const double wanted = predicted + throttle_integral_;
  const double step = up * p.throttle_integrator * error * dt;
  const bool winds_up =
      (wanted >= p.throttle_max && step > 0) || (wanted <= p.throttle_min && step < 0);
  if (!winds_up) throttle_integral_ += step;
  const double most = p.throttle_max - p.throttle_min;
  throttle_integral_ = std::clamp(throttle_integral_, -most, most);
  return std::clamp(wanted, p.throttle_min, p.throttle_max);
}

TotalEnergy::Output TotalEnergy::update(const Input& in, double dt) {
  const WingParams& p = params_;
  const double v = std::max(in.airspeed_m_s, kSlowestAir_m_s);
  const bool slow = !in.by_climb_alone && in.airspeed_m_s < kTooSlow * p.airspeed_min_m_s;
  const double by_height = in.by_climb_alone ? 0 : in.height_error_m / p.height_time_s;
  const double climb =
      std::clamp(in.climb_wanted_m_s + by_height, -p.sink_max_m_s, p.climb_max_m_s);
  const double quicker = (in.airspeed_wanted_m_s - in.airspeed_m_s) / p.airspeed_time_s;

  // Rates of potential and kinetic energy, wanted and measured.
  const double most = p.climb_max_m_s / v;
  const double potential_wanted = climb / v;
  const double kinetic_wanted = std::clamp(quicker / kGravityOfEnergy_m_s2, -most, most);
  const double potential = in.climb_m_s / v;
  const double kinetic = in.acceleration_m_s2 / kGravityOfEnergy_m_s2;

  Output out;
  const double total_wanted =
      std::clamp(potential_wanted + kinetic_wanted, -p.sink_max_m_s / v, most);
  out.throttle =
      slow ? p.throttle_max : throttle_for(total_wanted, total_wanted - potential - kinetic, v, dt);

  // The pitch: what does not count has no weight.
  const double weight = slow ? 2 : in.by_climb_alone ? 0 : p.speed_weight;
  const double of_speed = std::min(weight, 1.0);
  const double of_height = std::min(2 - weight, 1.0);
  const double balance_wanted = of_height * potential_wanted - of_speed * kinetic_wanted;
  const double error = balance_wanted - (of_height * potential - of_speed * kinetic);
  path_integral_ += p.pitch_integrator * error * dt;
  path_integral_ = std::clamp(path_integral_, -kMostTrim_rad, kMostTrim_rad);
  // The wanted rate of height is fed forward as an angle; that of speed is left to the throttle as
  // long as height counts in full.
  const double beforehand = of_height * potential_wanted - (1 - of_height) * kinetic_wanted;
  out.path_angle_rad = beforehand + p.pitch_damping * error + path_integral_;
  return out;
}

}  // namespace cas::fcu
