// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/mover.hpp"

#include <algorithm>
#include <cmath>

#include "base/frames.hpp"

namespace cas::fcu {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kApproach_per_s = 1.5;    // rate of the final approach, 1/s
constexpr double kVelocityGain_per_s = 6;  // how quickly the wanted speed is taken up, 1/s
constexpr double kBrakingShare = 0.6;  // part of the acceleration kept for braking: jerk needs room

/// Speed from which a stop within `distance` is still gentle.
double approach_speed(double distance, double acceleration) {
  const double brake = kBrakingShare * acceleration;
  const double linear = brake / (kApproach_per_s * kApproach_per_s);
  if (distance < linear) return kApproach_per_s * distance;
  return std::sqrt(2 * brake * (distance - 0.5 * linear));
}

double slewed(double from, double to, double step) {
  return from + std::clamp(to - from, -step, step);
}

}  // namespace

void Mover::reset(const Vector3d& p_N, const Vector3d& v_N, double yaw_rad) {
  p_N_ = target_N_ = p_N;
  v_N_ = v_N;
  a_N_.setZero();
  yaw_ = target_yaw_ = yaw_rad;
  yaw_rate_ = 0;
}

void Mover::shift(const Vector3d& by_N) {
  p_N_ += by_N;
  target_N_ += by_N;
}

void Mover::step_horizontal(double dt) {
  const Vector2d to_go = (target_N_ - p_N_).head<2>();
  const double distance = to_go.norm();
  const double speed =
      std::min(limits_.speed_m_s, approach_speed(distance, limits_.acceleration_m_s2));
  const Vector2d v_wanted = distance > 1e-9 ? Vector2d(to_go * (speed / distance)) : Vector2d(0, 0);
  Vector2d a_wanted = kVelocityGain_per_s * (v_wanted - v_N_.head<2>());
  const double excess = a_wanted.norm() / limits_.acceleration_m_s2;
  if (excess > 1) a_wanted /= excess;
  Vector2d change = a_wanted - a_N_.head<2>();
  const double step = limits_.jerk_m_s3 * dt;
  if (change.norm() > step) change *= step / change.norm();
  a_N_.head<2>() += change;
}

void Mover::step_vertical(double dt) {
  const double to_go = target_N_.z() - p_N_.z();  // down
  const bool down = to_go > 0;
  const double acceleration =
      std::min(limits_.acceleration_up_m_s2, limits_.acceleration_down_m_s2);
  const double speed = std::min(down ? limits_.down_m_s : limits_.up_m_s,
                                approach_speed(std::abs(to_go), acceleration));
  const double v_wanted = down ? speed : -speed;
  const double a_wanted = std::clamp(kVelocityGain_per_s * (v_wanted - v_N_.z()),
                                     -limits_.acceleration_up_m_s2, limits_.acceleration_down_m_s2);
  a_N_.z() = slewed(a_N_.z(), a_wanted, limits_.jerk_m_s3 * dt);
}

void Mover::step_yaw(double dt) {
  constexpr double kTurn_per_s = 2;
  constexpr double kTurnAcceleration_rad_s2 = 2;
  const double to_go = base::wrap_angle(target_yaw_ - yaw_);
  const double wanted =
      std::clamp(kTurn_per_s * to_go, -limits_.yaw_rate_rad_s, limits_.yaw_rate_rad_s);
  yaw_rate_ = slewed(yaw_rate_, wanted, kTurnAcceleration_rad_s2 * dt);
  yaw_ = base::wrap_angle(yaw_ + yaw_rate_ * dt);
}

TrajectorySetpoint Mover::update(double dt) {
  step_horizontal(dt);
  step_vertical(dt);
  step_yaw(dt);
  p_N_ += v_N_ * dt + a_N_ * (0.5 * dt * dt);
  v_N_ += a_N_ * dt;
  return {p_N_, v_N_, a_N_, yaw_, yaw_rate_};
}

bool Mover::arrived() const { return (target_N_ - p_N_).norm() < 0.05 && v_N_.norm() < 0.1; }

}  // namespace cas::fcu
