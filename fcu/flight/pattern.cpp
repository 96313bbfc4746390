// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/pattern.hpp"

#include <cmath>

namespace cas::fcu {

using Eigen::Vector3d;

Pattern::Phase Pattern::phase_at(double time_s, double full_rate) const {
  // The rate rises as s^2 (3 - 2 s): no jump of acceleration at either end.
  if (time_s <= 0) return {};
  if (time_s >= kStart_s) return {full_rate * (time_s - 0.5 * kStart_s), full_rate, 0};
  const double s = time_s / kStart_s;
  return {full_rate * kStart_s * s * s * s * (1 - 0.5 * s), full_rate * s * s * (3 - 2 * s),
          full_rate / kStart_s * 6 * s * (1 - s)};
}

TrajectorySetpoint Pattern::at(double time_s, const Vector3d& centre_N, double yaw_rad) const {
  TrajectorySetpoint out{centre_N, Vector3d::Zero(), Vector3d::Zero(), yaw_rad, 0};
  if (shape_ == PatternShape::kCircle) {
    // Starts at the centre's north; the way there is the position loop's.
    const auto [angle, rate, acceleration] = phase_at(time_s, speed_m_s_ / size_m_);
    const Vector3d radial(std::cos(angle), std::sin(angle), 0);
    const Vector3d tangent(-std::sin(angle), std::cos(angle), 0);
    out.p_N += size_m_ * radial;
    out.v_N = size_m_ * rate * tangent;
    out.a_N = size_m_ * (acceleration * tangent - rate * rate * radial);
  } else if (shape_ == PatternShape::kFigureEight) {
    // x = size sin(a), y = size / 2 sin(2 a): fastest at the crossing, size sqrt(2) rate.
    const auto [angle, rate, acceleration] =
        phase_at(time_s, speed_m_s_ / (size_m_ * std::sqrt(2.0)));
    const Vector3d shape(std::sin(angle), 0.5 * std::sin(2 * angle), 0);
    const Vector3d first(std::cos(angle), std::cos(2 * angle), 0);
    const Vector3d second(-std::sin(angle), -2 * std::sin(2 * angle), 0);
    out.p_N += size_m_ * shape;
    out.v_N = size_m_ * rate * first;
    out.a_N = size_m_ * (acceleration * first + rate * rate * second);
  } else if (shape_ == PatternShape::kSteps) {
    const bool away = std::fmod(time_s, 2 * period_s_) >= period_s_;
    if (away) out.p_N.x() += size_m_;
  }
  return out;
}

}  // namespace cas::fcu
