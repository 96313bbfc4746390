// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/manual_task.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::fcu {
namespace {

constexpr double kGravity_m_s2 = 9.80665;
constexpr double kLongestLead_m = 2;  // setpoint ahead of the estimate, when held back

double outside_deadzone(double stick, double zone) {
  if (std::abs(stick) <= zone) return 0;
  return std::copysign((std::abs(stick) - zone) / (1 - zone), stick);
}

}  // namespace

void ManualTask::activate(const TaskContext& context) {
  p_N_ = context.estimate.p_N;
  v_N_ = context.estimate.v_N;
  yaw_rad_ = context.yaw_rad;
}

ControlSetpoint ManualTask::stabilized(const Sticks& sticks, const TaskContext& context) {
  const FlightParams& p = context.params;
  // Mid stick hovers.
  const double thrust = sticks.throttle < 0.5
                            ? std::lerp(p.thrust_min, p.hover_thrust, 2 * sticks.throttle)
                            : std::lerp(p.hover_thrust, 1.0, 2 * sticks.throttle - 1);
  AttitudeSetpoint attitude;
  attitude.q_ND = base::quaternion_rpy(sticks.roll * p.manual_tilt_rad,
                                       -sticks.pitch * p.manual_tilt_rad, yaw_rad_);
  attitude.thrust_n = thrust * context.full_thrust_n;
  attitude.yaw_rate_rad_s = sticks.yaw * p.manual_yaw_rate_rad_s;
  ControlSetpoint out;
  out.attitude = attitude;
  return out;
}

double ManualTask::climb(const Sticks& sticks, const TaskContext& context) const {
  const double stick = outside_deadzone(2 * sticks.throttle - 1, context.params.stick_deadzone);
  return stick * (stick > 0 ? context.params.climb_speed_m_s : context.params.descent_speed_m_s);
}

void ManualTask::hold_height(double climb_m_s, const TaskContext& context,
                             TrajectorySetpoint& out) {
  const double step = context.params.acceleration_up_m_s2 * context.dt;
  v_N_.z() += std::clamp(-climb_m_s - v_N_.z(), -step, step);
  const double z = context.estimate.p_N.z();
  p_N_.z() = std::clamp(p_N_.z() + v_N_.z() * context.dt, z - kLongestLead_m, z + kLongestLead_m);
  out.p_N.z() = p_N_.z();
  out.v_N.z() = v_N_.z();
}

ControlSetpoint ManualTask::update(const TaskContext& context) {
  const Sticks sticks = context.sticks.value_or(Sticks{});
  const FlightParams& p = context.params;
  yaw_rad_ = base::wrap_angle(yaw_rad_ + sticks.yaw * p.manual_yaw_rate_rad_s * context.dt);
  if (mode_ == FlightMode::kStabilized) return stabilized(sticks, context);

  TrajectorySetpoint out;
  hold_height(climb(sticks, context), context, out);
  out.yaw_rad = yaw_rad_;
  out.yaw_rate_rad_s = sticks.yaw * p.manual_yaw_rate_rad_s;
  const Eigen::Rotation2Dd heading(context.yaw_rad);
  if (mode_ == FlightMode::kAltitude || !context.position_valid) {
    const Eigen::Vector2d tilt = p.manual_tilt_rad * Eigen::Vector2d(sticks.pitch, sticks.roll);
    out.a_N.head<2>() = heading * Eigen::Vector2d(kGravity_m_s2 * std::tan(tilt.x()),
                                                  kGravity_m_s2 * std::tan(tilt.y()));
    p_N_.head<2>() = context.estimate.p_N.head<2>();
    v_N_.head<2>() = context.estimate.v_N.head<2>();
  } else {
    const Eigen::Vector2d wanted =
        heading *
        Eigen::Vector2d(outside_deadzone(sticks.pitch, p.stick_deadzone),
                        outside_deadzone(sticks.roll, p.stick_deadzone)) *
        p.manual_speed_m_s;
    Eigen::Vector2d change = wanted - v_N_.head<2>();
    const double step = p.acceleration_m_s2 * context.dt;
    if (change.norm() > step) change *= step / change.norm();
    v_N_.head<2>() += change;
    p_N_.head<2>() += v_N_.head<2>() * context.dt;
    const Eigen::Vector2d lead = p_N_.head<2>() - context.estimate.p_N.head<2>();
    if (lead.norm() > kLongestLead_m) {
      p_N_.head<2>() -= lead * (1 - kLongestLead_m / lead.norm());
    }
    out.p_N.head<2>() = p_N_.head<2>();
    out.v_N.head<2>() = v_N_.head<2>();
  }
  ControlSetpoint result;
  result.trajectory = out;
  return result;
}

bool ManualTask::wants_takeoff(const TaskContext& context) const {
  if (!context.sticks) return false;
  return context.sticks->throttle > (mode_ == FlightMode::kStabilized ? 0.15 : 0.65);
}

bool ManualTask::descending(const TaskContext& context) const {
  if (!context.sticks) return false;
  return context.sticks->throttle < (mode_ == FlightMode::kStabilized ? 0.15 : 0.4);
}

}  // namespace cas::fcu
