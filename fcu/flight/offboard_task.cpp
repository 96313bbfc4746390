// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/offboard_task.hpp"

#include <cmath>

namespace cas::fcu {
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
