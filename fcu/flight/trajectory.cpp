// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::fcu {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kApproach_per_s = 1.5;    // rate of the final approach, 1/s
constexpr double kVelocityGain_per_s = 6;  // how quickly the wanted speed is taken up, 1/s
constexpr double kBrakingShare = 0.6;      // part of the acceleration used for braking

/// Speed from which a stop within `distance` is still gentle.
double approach_speed(double distance, double acceleration) {
  const double brake = kBrakingShare * acceleration;
  const double linear = brake / (kApproach_per_s * kApproach_per_s);
  if (distance < linear) return kApproach_per_s * std::max(0.0, distance);
  return std::sqrt(2 * brake * (distance - 0.5 * linear));
}

/// Time until braking bites: the acceleration must be built up first.
double braking_delay(double acceleration, double jerk) {
  return 0.5 * kBrakingShare * acceleration / jerk + 0.5 / kVelocityGain_per_s;
}

/// Acceleration that takes up a difference of speed without shooting past it.
double wanted_acceleration(double difference, double most, double jerk) {
  constexpr double kShare = 0.8;
  return std::min(
      {most, kVelocityGain_per_s * difference, kShare * std::sqrt(2 * jerk * difference)});
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
  const double most = limits_.acceleration_m_s2;
  const Vector2d v = v_N_.head<2>();
  const Vector2d to_go = (target_N_ - p_N_).head<2>() - v * braking_delay(most, limits_.jerk_m_s3);
  const double distance = to_go.norm();
  const double speed = std::min(limits_.speed_m_s, approach_speed(distance, most));
  const Vector2d v_wanted = distance > 1e-9 ? Vector2d(to_go * (speed / distance)) : Vector2d(0, 0);
  const Vector2d difference = v_wanted - v;
  const double length = difference.norm();
  const Vector2d a_wanted =
      length > 1e-9
          ? Vector2d(difference * (wanted_acceleration(length, most, limits_.jerk_m_s3) / length))
          : Vector2d(0, 0);
  Vector2d change = a_wanted - a_N_.head<2>();
  const double step = limits_.jerk_m_s3 * dt;
  if (change.norm() > step) change *= step / change.norm();
  a_N_.head<2>() += change;
}

void Mover::step_vertical(double dt) {
  const double least = std::min(limits_.acceleration_up_m_s2, limits_.acceleration_down_m_s2);
  const double to_go =
      target_N_.z() - p_N_.z() - v_N_.z() * braking_delay(least, limits_.jerk_m_s3);  // down
  const bool down = to_go > 0;
  const double speed =
      std::min(down ? limits_.down_m_s : limits_.up_m_s, approach_speed(std::abs(to_go), least));
  const double difference = (down ? speed : -speed) - v_N_.z();
  const double most =
      difference > 0 ? limits_.acceleration_down_m_s2 : limits_.acceleration_up_m_s2;
  const double a_wanted =
      std::copysign(wanted_acceleration(std::abs(difference), most, limits_.jerk_m_s3), difference);
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
