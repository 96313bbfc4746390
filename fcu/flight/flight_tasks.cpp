// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/flight_tasks.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"

namespace cas::fcu {

using Eigen::Vector3d;

MoverLimits mover_limits(const FlightParams& params) {
  MoverLimits limits;
  limits.speed_m_s = params.cruise_speed_m_s;
  limits.up_m_s = params.climb_speed_m_s;
  limits.down_m_s = params.descent_speed_m_s;
  limits.acceleration_m_s2 = params.acceleration_m_s2;
  limits.acceleration_up_m_s2 = params.acceleration_up_m_s2;
  limits.acceleration_down_m_s2 = params.acceleration_down_m_s2;
  limits.jerk_m_s3 = params.jerk_m_s3;
  limits.yaw_rate_rad_s = params.yaw_rate_limit_rad_s;
  return limits;
}

// Hold.

void HoldTask::activate(const TaskContext& context) {
  // Where the vehicle would come to rest, so that it brakes instead of flying back.
  const Vector3d& v = context.estimate.v_N;
  mover_.set_limits(mover_limits(context.params));
  mover_.reset(context.estimate.p_N, v, context.yaw_rad);
  const double stop_s = v.norm() / std::max(context.params.acceleration_m_s2, 0.5);
  if (v.norm() > 0.5) mover_.set_target(context.estimate.p_N + 0.5 * v * stop_s);
  speed_m_s_ = -1;
  pattern_.reset();
  pattern_param_ = 0;
}

void HoldTask::go_to(const Vector3d& p_N, double yaw_rad, double speed_m_s) {
  Vector3d target = mover_.target();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isfinite(p_N[axis])) target[axis] = p_N[axis];
  }
  mover_.set_target(target);
  if (std::isfinite(yaw_rad)) mover_.set_yaw(yaw_rad);
  speed_m_s_ = speed_m_s;
  pattern_.reset();
}

void HoldTask::fly_pattern(PatternShape shape, double size_m, double speed_m_s, double period_s) {
  pattern_.reset();
  if (shape == PatternShape::kNone) return;
  pattern_.emplace(shape, size_m, speed_m_s, period_s);
  pattern_time_s_ = 0;
  pattern_centre_N_ = mover_.target();
}

void HoldTask::settle(const Vector3d& p_N, double yaw_rad) {
  mover_.reset(p_N, Vector3d::Zero(), yaw_rad);
}

ControlSetpoint HoldTask::update(const TaskContext& context) {
  const FlightParams& p = context.params;
  if (p.pattern_shape != pattern_param_) {
    pattern_param_ = p.pattern_shape;
    fly_pattern(static_cast<PatternShape>(p.pattern_shape), p.pattern_size_m, p.pattern_speed_m_s,
                p.pattern_period_s);
  }
  MoverLimits limits = mover_limits(p);
  if (speed_m_s_ > 0) limits.speed_m_s = speed_m_s_;
  mover_.set_limits(limits);
  ControlSetpoint out;
  out.trajectory = mover_.update(context.dt);
  if (pattern_) {
    out.trajectory = pattern_->at(pattern_time_s_, pattern_centre_N_, mover_.yaw());
    pattern_time_s_ += context.dt;
  }
  return out;
}

// Take-off.

void TakeoffTask::activate(const TaskContext& context) {
  mover_.reset(context.estimate.p_N, Vector3d::Zero(), context.yaw_rad);
  clear_ = false;
  usual_height_m_ = context.params.takeoff_altitude_m;
  aim(context);
}

void TakeoffTask::aim(const TaskContext& context) {
  Vector3d target = mover_.target();
  target.z() = wanted_z_.value_or(context.ground_z - usual_height_m_);
  mover_.set_target(target);
  if (std::isfinite(wanted_yaw_)) mover_.set_yaw(wanted_yaw_);
}

ControlSetpoint TakeoffTask::update(const TaskContext& context) {
  MoverLimits limits = mover_limits(context.params);
  limits.up_m_s = context.params.takeoff_speed_m_s;
  mover_.set_limits(limits);
  ControlSetpoint out;
  constexpr double kClear_m = 0.15;
  if (!clear_ && context.ground_z - context.estimate.p_N.z() > kClear_m) {
    clear_ = true;  // the place it left the ground at, not the one it was put down at
    Vector3d here = context.estimate.p_N;
    here.z() = mover_.position().z();
    mover_.reset(here, context.estimate.v_N, mover_.yaw());
  }
  aim(context);
  out.trajectory = mover_.update(context.dt);
  if (!clear_) {  // straight up: feet on the ground must not be pulled aside
    out.near_ground = true;
    out.trajectory->p_N.head<2>().setConstant(kUnset);
    out.trajectory->v_N.head<2>().setConstant(kUnset);
    out.trajectory->a_N.head<2>().setConstant(kUnset);
  }
  return out;
}

bool TakeoffTask::done(const TaskContext& context) const {
  return mover_.arrived() && std::abs(context.estimate.p_N.z() - mover_.target().z()) < 0.3;
}

// Land.

void LandTask::activate(const TaskContext& context) {
  mover_.reset(context.estimate.p_N, context.estimate.v_N, context.yaw_rad);
  speed_m_s_ = std::clamp(context.estimate.v_N.z(), 0.0, context.params.descent_speed_m_s);
}

ControlSetpoint LandTask::update(const TaskContext& context) {
  const FlightParams& p = context.params;
  const double height = context.ground_z - context.estimate.p_N.z();
  const double wanted = height > p.land_slow_altitude_m ? p.descent_speed_m_s : p.land_speed_m_s;
  constexpr double kSlew_m_s2 = 1;
  speed_m_s_ += std::clamp(wanted - speed_m_s_, -kSlew_m_s2 * context.dt, kSlew_m_s2 * context.dt);

  mover_.set_limits(mover_limits(p));
  TrajectorySetpoint setpoint = mover_.update(context.dt);
  setpoint.p_N.z() = kUnset;  // the ground is where it is: by speed only
  setpoint.v_N.z() = speed_m_s_;
  setpoint.a_N.z() = kUnset;
  if (!context.position_valid) {  // level, nothing else is known
    setpoint.p_N.head<2>().setConstant(kUnset);
    setpoint.v_N.head<2>().setConstant(kUnset);
    setpoint.a_N.head<2>().setConstant(kUnset);
  }
  ControlSetpoint out;
  out.trajectory = setpoint;
  // At any height: an estimate that is wrong by metres must not tip over a vehicle on the ground.
  out.tilt_limit_rad = p.land_tilt_rad;
  return out;
}

// Return.

void ReturnTask::activate(const TaskContext& context) {
  mover_.reset(context.estimate.p_N, context.estimate.v_N, context.yaw_rad);
  enter(Stage::kClimb, context);
}

void ReturnTask::enter(Stage stage, const TaskContext& context) {
  constexpr double kNearHome_m = 3;
  stage_ = stage;
  const Vector3d& p = context.estimate.p_N;
  const Vector3d& home = context.home_N;
  const double distance = (home - p).head<2>().norm();
  Vector3d target = mover_.target();
  if (stage == Stage::kClimb) {
    // Close to home the height of the descent is enough.
    const double height = distance < kNearHome_m ? context.params.return_descend_altitude_m
                                                 : context.params.return_altitude_m;
    target = Vector3d(mover_.target().x(), mover_.target().y(), std::min(p.z(), home.z() - height));
    if (distance < kNearHome_m) target.z() = std::min(p.z(), home.z());
  } else if (stage == Stage::kCruise) {
    target.head<2>() = home.head<2>();
    if (distance > kNearHome_m) {
      mover_.set_yaw(std::atan2(home.y() - p.y(), home.x() - p.x()));
    }
  } else if (stage == Stage::kDescend) {
    target.z() = std::max(mover_.target().z(), home.z() - context.params.return_descend_altitude_m);
  } else if (stage == Stage::kWait) {
    waited_s_ = 0;
  } else {
    land_.activate(context);
  }
  mover_.set_target(target);
}

ControlSetpoint ReturnTask::update(const TaskContext& context) {
  if (stage_ == Stage::kLand) return land_.update(context);
  mover_.set_limits(mover_limits(context.params));
  ControlSetpoint out;
  out.trajectory = mover_.update(context.dt);
  if (stage_ == Stage::kWait) {
    waited_s_ += context.dt;
    const double delay = context.params.return_land_delay_s;
    if (delay >= 0 && waited_s_ >= delay) enter(Stage::kLand, context);
  } else if (mover_.arrived()) {
    enter(static_cast<Stage>(static_cast<int>(stage_) + 1), context);
  }
  return out;
}

// Manual.

namespace {

constexpr double kGravity_m_s2 = base::kStandardGravity_m_s2;
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

// Offboard.

namespace {

constexpr double kOffGround_m = 0.15;

}  // namespace

void OffboardTask::on_trajectory(const TrajectorySetpoint& setpoint, base::RunTime now) {
  trajectory_ = setpoint;
  attitude_.reset();
  last_ = now;
  heard_ = true;
}

void OffboardTask::on_attitude(const AttitudeSetpoint& setpoint, base::RunTime now) {
  attitude_ = setpoint;
  trajectory_.reset();
  last_ = now;
  heard_ = true;
}

bool OffboardTask::alive(base::RunTime now, double timeout_s) const {
  return heard_ && base::to_seconds(now - last_) <= timeout_s;
}

void OffboardTask::activate(const TaskContext& context) { yaw_rad_ = context.yaw_rad; }

ControlSetpoint OffboardTask::update(const TaskContext& context) {
  ControlSetpoint out;
  out.trajectory = trajectory_;
  out.attitude = attitude_;
  if (!out.trajectory && !out.attitude) {
    out.trajectory = TrajectorySetpoint{};
    out.trajectory->p_N = context.estimate.p_N;
  }
  if (out.trajectory) {
    double& yaw = out.trajectory->yaw_rad;
    if (std::isfinite(yaw)) yaw_rad_ = yaw;
    // Without any word on heading the present one is kept.
    if (!std::isfinite(yaw) && !std::isfinite(out.trajectory->yaw_rate_rad_s)) yaw = yaw_rad_;
  }
  return out;
}

bool OffboardTask::wants_takeoff(const TaskContext& context) const {
  if (attitude_)
    return attitude_->thrust_n > 0.5 * context.params.hover_thrust * context.full_thrust_n;
  if (!trajectory_) return false;
  const TrajectorySetpoint& t = *trajectory_;
  return (std::isfinite(t.p_N.z()) && t.p_N.z() < context.ground_z - kOffGround_m) ||
         (std::isfinite(t.v_N.z()) && t.v_N.z() < -0.1) ||
         (std::isfinite(t.a_N.z()) && t.a_N.z() < -0.1);
}

bool OffboardTask::descending(const TaskContext& context) const {
  if (attitude_) return true;
  if (!trajectory_) return false;
  const TrajectorySetpoint& t = *trajectory_;
  if (std::isfinite(t.p_N.z())) return t.p_N.z() > context.estimate.p_N.z() + kOffGround_m;
  return std::isfinite(t.v_N.z()) && t.v_N.z() > 0.1;
}

}  // namespace cas::fcu
