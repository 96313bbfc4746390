// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>

#include "libsim/core/body/shape.hpp"

namespace cas::sim {

/// Spring and damper along the normal of one contact: N/m, N s/m.
struct ContactSpring {
  double stiffness = 0;
  double damping = 0;

  /// Force at a depth (m) and a speed of approach (m/s), N; a contact does not pull.
  double force(double depth_m, double approach_m_s) const {
    return std::max(0.0, stiffness * depth_m + damping * std::max(0.0, approach_m_s));
  }
};

/// Spring that a whole patch of contacts has where no file says otherwise: a mass on a spring of
/// 90 rad/s damped by 0.7 of the critical. It sinks by g / w^2 = 1.2 mm under its weight, meets the
/// ground at 1 m/s with at most 2 z w v = 126 m/s^2 (12.8 g) and leaves it at a sixth of that.
/// Scaled by the mass that the patch feels, so that small and large vehicles land alike, and so do
/// a level and a tilted one: an edge that comes first has only a share of the mass to stop, and
/// turns the rest.
inline constexpr double kPatchFrequency = 90.0;  // rad/s
inline constexpr double kPatchDampingRatio = 0.7;
/// Deeper than a landing goes, the patch grows stiffer with the square of the depth: a crash stays
/// out of thin ground.
inline constexpr double kLandingDepth = 6e-3;  // m

/// Share of the default spring that one contact of a patch takes.
///
/// Stiffness is shared by depth, so that a contact begins and ends without a jump, and damping
/// evenly; neither legs nor triangles make the ground harder by their number.
/// @param mass_kg  that a push on the patch has to move
/// @param depth_sum_m, count  of all contacts of the patch
inline ContactSpring default_spring(double mass_kg, double depth_m, double depth_sum_m,
                                    std::size_t count) {
  constexpr double kSmallestShare = 1e-3;
  const double even = 1.0 / static_cast<double>(count);
  const double share = std::max(kSmallestShare, depth_sum_m > 0 ? depth_m / depth_sum_m : even);
  const double deep = std::max(1.0, depth_m / kLandingDepth);
  const double mass = mass_kg * deep * deep;
  return {.stiffness = share * mass * kPatchFrequency * kPatchFrequency,
          .damping = even * 2.0 * kPatchDampingRatio * mass * kPatchFrequency};
}

/// True where at least one of the two surfaces names stiffness or damping.
inline bool has_own_spring(const Surface& a, const Surface& b) {
  return a.stiffness_n_m || b.stiffness_n_m || a.damping_n_s_m || b.damping_n_s_m;
}

inline constexpr double kSdfStiffness = 1e12;  // N/m, default of <kp>
inline constexpr double kSdfDamping = 1.0;     // N s/m, default of <kd>

/// Spring of one contact between surfaces of which at least one names its own: stiffnesses in
/// series, dampings added, as Gazebo combines `kp` and `kd`. A value that neither names is the
/// default of the SDF specification (1e12 N/m, 1 N s/m).
inline ContactSpring own_spring(const Surface& a, const Surface& b) {
  const auto softness = [](const Surface& s) {
    return 1.0 / s.stiffness_n_m.value_or(kSdfStiffness);
  };
  const double damping = a.damping_n_s_m.value_or(0) + b.damping_n_s_m.value_or(0);
  const bool named = a.damping_n_s_m || b.damping_n_s_m;
  return {.stiffness = 1.0 / (softness(a) + softness(b)), .damping = named ? damping : kSdfDamping};
}

/// Share of Coulomb's limit that a contact has across the direction in which it would slip.
///
/// ODE limits friction by a box whose first side is laid along that direction. A clearly slipping
/// contact must have none across it, or it would never turn towards the pull; a sticking one needs
/// a hold on every side.
/// @param slip_m_s  at the end of the step without friction
/// @param stop_m_s  speed that friction can remove within the step
inline double hold_across(double slip_m_s, double stop_m_s) {
  if (!(stop_m_s > 0)) return 0.0;
  return std::clamp(2.0 - slip_m_s / stop_m_s, 0.0, 1.0);
}

}  // namespace cas::sim
