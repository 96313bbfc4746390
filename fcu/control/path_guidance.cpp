// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/path_guidance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cas::fcu {

using Eigen::Vector2d;

namespace {

constexpr double kLeastSpeed_m_s = 1;

/// North and east: above 0 where b lies to the right of a.
double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double lookahead_m(const PathGains& gains, double speed) {
  return gains.damping * gains.period_s * speed / std::numbers::pi;
}

/// Towards a direction; behind the vehicle as hard as at right angles.
double turn_towards(const Vector2d& way_N, const PathGains& gains, const Vector2d& v_N) {
  constexpr double kRightAngle = std::numbers::pi / 2;
  const double speed = std::max(v_N.norm(), kLeastSpeed_m_s);
  const double eta =
      std::clamp(std::atan2(cross(v_N, way_N), v_N.dot(way_N)), -kRightAngle, kRightAngle);
  const double gain = 4 * gains.damping * gains.damping;
  return gain * speed * speed / lookahead_m(gains, speed) * std::sin(eta);
}

double along(const LinePath& line, const PathGains& gains, const Vector2d& p_N,
             const Vector2d& v_N) {
  const Vector2d ahead = line.direction();
  const Vector2d right(-ahead.y(), ahead.x());
  const double off_m = (p_N - line.from_N).dot(right);
  const double reach_m = lookahead_m(gains, std::max(v_N.norm(), kLeastSpeed_m_s));
  const double aside_m = std::clamp(-off_m, -0.9 * reach_m, 0.9 * reach_m);
  const double along_m = std::sqrt(reach_m * reach_m - aside_m * aside_m);
  return turn_towards(along_m * ahead + aside_m * right, gains, v_N);
}

double about(const CirclePath& circle, const PathGains& gains, const Vector2d& p_N,
             const Vector2d& v_N) {
  const double radius = std::abs(circle.radius_m);
  const double right = circle.radius_m < 0 ? -1 : 1;  // where the middle lies
  const Vector2d from_middle = p_N - circle.centre_N;
  const double distance = from_middle.norm();
  if (distance < 1e-3) return 0;
  const Vector2d outward = from_middle / distance;
  const double off_m = distance - radius;
  const double tangential = right * cross(outward, v_N);

  const double w = 2 * std::numbers::pi / gains.period_s;
  double inward = w * w * off_m + 2 * gains.damping * w * v_N.dot(outward);
  if (tangential < 0) inward = std::max(inward, 0.0);  // the wrong way round: turn about
  inward += tangential * tangential / std::max(0.5 * radius, distance);
  const double on_circle = right * inward;
  const double to_middle = turn_towards(-from_middle, gains, v_N);
  return off_m > 0 && right * to_middle < right * on_circle ? to_middle : on_circle;
}

}  // namespace

double path_acceleration_m_s2(const Path& path, const PathGains& gains, const Vector2d& p_N,
                              const Vector2d& v_N) {
  if (const auto* line = std::get_if<LinePath>(&path)) return along(*line, gains, p_N, v_N);
  return about(std::get<CirclePath>(path), gains, p_N, v_N);
}

}  // namespace cas::fcu
