// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/aero/glide_polar.hpp"

#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::sim {
namespace {

/// Lift, drag (N) and pitching moment (N m, nose up).
struct Forces {
  double lift = 0;
  double drag = 0;
  double moment = 0;
};

Forces forces_at(const Airframe& airframe, double speed_m_s, double alpha_rad,
                 std::span<const double> deflections) {
  const Trim flight{.speed_m_s = speed_m_s,
                    .alpha_rad = alpha_rad,
                    .pitch_rad = alpha_rad,
                    .deflections_rad = {}};
  const Wrench wrench = airframe.wrench(body_of(state_of(flight)), deflections, 0);
  const double c = std::cos(alpha_rad);
  const double s = std::sin(alpha_rad);
  return {.lift = wrench.force_B.z() * c + wrench.force_B.x() * s,
          .drag = wrench.force_B.z() * s - wrench.force_B.x() * c,
          .moment = -wrench.torque_B.y()};
}

/// Forces with the moment balanced by the smallest deflections, to which it is linear; nullopt
/// where the surfaces cannot.
std::optional<Forces> balanced(const Airframe& airframe, double speed_m_s, double alpha_rad,
                               const std::vector<std::pair<double, double>>& limits_rad) {
  std::vector<double> deflections(airframe.surfaces);
  const double still = forces_at(airframe, speed_m_s, alpha_rad, deflections).moment;
  std::vector<double> effects;
  double square = 0;
  for (std::size_t i = 0; i < deflections.size(); ++i) {
    deflections[i] = 0.1;
    effects.push_back((forces_at(airframe, speed_m_s, alpha_rad, deflections).moment - still) /
                      0.1);
    square += effects[i] * effects[i];
    deflections[i] = 0;
  }
  if (square <= 0) return std::nullopt;
  for (std::size_t i = 0; i < deflections.size(); ++i) {
    deflections[i] = -still * effects[i] / square;
    if (deflections[i] < limits_rad[i].first || deflections[i] > limits_rad[i].second) {
      return std::nullopt;
    }
  }
  return forces_at(airframe, speed_m_s, alpha_rad, deflections);
}

}  // namespace

std::optional<GlidePolar> glide_polar(const Airframe& aerodynamics, double speed_m_s,
                                      const std::vector<std::pair<double, double>>& limits_rad) {
  constexpr double kStep_rad = 0.0005;
  constexpr int kLeast = -200;
  constexpr int kMost = 1570;  // 45 deg
  const double weight_n = aerodynamics.mass_kg * aerodynamics.air.gravity_W.norm();
  GlidePolar polar;
  double most_lift = 0;
  for (int i = kLeast; i <= kMost; ++i) {
    const double alpha_rad = i * kStep_rad;
    const std::optional<Forces> forces = balanced(aerodynamics, speed_m_s, alpha_rad, limits_rad);
    if (!forces || forces->lift <= 0 || forces->drag <= 0) continue;
    if (forces->lift > most_lift) {
      most_lift = forces->lift;
      polar.stall_alpha_rad = alpha_rad;
    }
    const double ratio = forces->lift / forces->drag;
    if (ratio <= polar.best_glide_ratio) continue;
    polar.best_glide_ratio = ratio;
    polar.best_glide_m_s = speed_m_s * std::sqrt(weight_n / std::hypot(forces->lift, forces->drag));
  }
  if (most_lift <= 0) return std::nullopt;
  polar.stall_speed_m_s = speed_m_s * std::sqrt(weight_n / most_lift);
  return polar;
}

}  // namespace cas::sim
