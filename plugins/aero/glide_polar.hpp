// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "plugins/aero/trim.hpp"

namespace cas::sim {

/// What a vehicle does without thrust, its surfaces balancing the pitching moment.
struct GlidePolar {
  double stall_speed_m_s = 0;   ///< at the greatest lift, level: the weight over it
  double stall_alpha_rad = 0;   ///< angle of attack there
  double best_glide_ratio = 0;  ///< way over height
  double best_glide_m_s = 0;    ///< airspeed there
};

/// @param aerodynamics  airframe whose wrench at throttle 0 is the air's alone, with rotors that
///                      stand
/// @param speed_m_s     at which it is asked; its forces are taken to go with the square of it
/// @param limits_rad    least and greatest deflection of each surface
/// @return nullopt where no angle of attack up to 45 deg can be balanced and lifts
std::optional<GlidePolar> glide_polar(const Airframe& aerodynamics, double speed_m_s,
                                      const std::vector<std::pair<double, double>>& limits_rad);

}  // namespace cas::sim
