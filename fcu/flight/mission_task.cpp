// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/mission_task.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/angles.hpp"
#include "base/earth/deg_e7.hpp"

namespace cas::fcu {

using Eigen::Vector3d;
using mavlink::common::MavCmd;
using mavlink::common::MavFrame;
using mavlink::common::MavMissionResult;

namespace {

bool has_place(MavCmd command) {
  switch (command) {
    case MavCmd::kNavWaypoint:
    case MavCmd::kNavLoiterUnlim:
    case MavCmd::kNavLoiterTime:
    case MavCmd::kNavLand:
    case MavCmd::kNavTakeoff:
      return true;
    default:
      return false;
  }
}

bool is_absolute(MavFrame frame) {
  return frame == MavFrame::kGlobal || frame == MavFrame::kGlobalInt;
}
bool is_relative(MavFrame frame) {
  return frame == MavFrame::kGlobalRelativeAlt || frame == MavFrame::kGlobalRelativeAltInt;
}

}  // namespace

MavMissionResult MissionTask::check(const MissionItem& item) {
  switch (item.command) {
    case MavCmd::kNavWaypoint:
    case MavCmd::kNavLoiterUnlim:
    case MavCmd::kNavLoiterTime:
    case MavCmd::kNavLand:
    case MavCmd::kNavTakeoff:
      break;
    case MavCmd::kNavReturnToLaunch:
    case MavCmd::kNavDelay:
    case MavCmd::kDoChangeSpeed:
      return MavMissionResult::kAccepted;
    default:
      return MavMissionResult::kUnsupported;
  }
  if (!is_absolute(item.frame) && !is_relative(item.frame)) {
    return MavMissionResult::kUnsupportedFrame;
  }
  if (!std::isfinite(item.z)) return MavMissionResult::kInvalidParam7;
  return MavMissionResult::kAccepted;
}

void MissionTask::set_items(std::vector<MissionItem> items) {
  items_ = std::move(items);
  current_ = 0;
  started_ = finished_ = landing_ = false;
  wanted_mode_.reset();
  reached_.reset();
}

bool MissionTask::set_current(std::size_t index) {
  if (index >= items_.size()) return false;
  current_ = index;
  started_ = finished_ = landing_ = false;
  wanted_mode_.reset();
  return true;
}

std::optional<std::uint16_t> MissionTask::take_reached() { return std::exchange(reached_, {}); }

void MissionTask::activate(const TaskContext& context) {
  mover_.reset(context.estimate.p_N, context.estimate.v_N, context.yaw_rad);
  if (finished_) set_current(0);
  started_ = false;
  landing_ = false;
  wanted_mode_.reset();
}

Vector3d MissionTask::place(const MissionItem& item, const TaskContext& context) const {
  Vector3d p_N = mover_.target();
  if (!context.projection) return p_N;
  base::Geodetic there;
  there.lat_deg = base::degrees_of_e7(item.x);
  there.lon_deg = base::degrees_of_e7(item.y);
  there.alt_m = context.projection->home().alt_m;
  const bool here = item.x == 0 && item.y == 0;
  if (!here) p_N.head<2>() = context.projection->to_local(there).head<2>();
  p_N.z() = is_relative(item.frame) ? context.home_N.z() - item.z
                                    : -(item.z - context.projection->home().alt_m);
  return p_N;
}

void MissionTask::start_item(const TaskContext& context) {
  const MissionItem& item = items_[current_];
  started_ = true;
  waited_s_ = 0;
  landing_ = false;
  if (item.command == MavCmd::kDoChangeSpeed && item.param[1] > 0) speed_m_s_ = item.param[1];
  if (item.command == MavCmd::kNavReturnToLaunch) wanted_mode_ = FlightMode::kReturn;
  if (!has_place(item.command)) return;

  Vector3d target = place(item, context);
  if (item.command == MavCmd::kNavTakeoff) target.head<2>() = mover_.target().head<2>();
  if (item.command == MavCmd::kNavLand) target.z() = mover_.target().z();
  mover_.set_target(target);
  const Vector3d way = target - context.estimate.p_N;
  const double yaw = item.param[3];
  if (std::isfinite(yaw) && yaw != 0) {
    mover_.set_yaw(base::radians(yaw));
  } else if (item.command == MavCmd::kNavWaypoint && way.head<2>().norm() > 2) {
    mover_.set_yaw(std::atan2(way.y(), way.x()));
  }
}

bool MissionTask::reached(const TaskContext& context) const {
  const Vector3d off = mover_.target() - context.estimate.p_N;
  const double own = items_[current_].param[1];
  const double radius = items_[current_].command == MavCmd::kNavWaypoint && own > 0
                            ? own
                            : context.params.acceptance_radius_m;
  return off.head<2>().norm() < radius && std::abs(off.z()) < context.params.acceptance_height_m;
}

void MissionTask::next(const TaskContext& context) {
  reached_ = static_cast<std::uint16_t>(current_);
  if (current_ + 1 >= items_.size()) {
    finished_ = true;
    return;
  }
  ++current_;
  start_item(context);
}

ControlSetpoint MissionTask::update(const TaskContext& context) {
  const bool flown = !items_.empty() && !finished_;
  if (flown && !started_) start_item(context);
  if (landing_) return land_.update(context);

  MoverLimits limits = mover_limits(context.params);
  if (speed_m_s_ > 0) limits.speed_m_s = speed_m_s_;
  mover_.set_limits(limits);
  ControlSetpoint out;
  out.trajectory = mover_.update(context.dt);
  if (flown) continue_item(context);
  return out;
}

void MissionTask::continue_item(const TaskContext& context) {
  const MissionItem& item = items_[current_];
  switch (item.command) {
    case MavCmd::kNavTakeoff:
      if (reached(context)) next(context);
      break;
    case MavCmd::kNavWaypoint:
    case MavCmd::kNavLoiterTime:
      if (reached(context)) waited_s_ += context.dt;
      if (waited_s_ > 0 && waited(item)) next(context);
      break;
    case MavCmd::kNavDelay:
      waited_s_ += context.dt;
      if (waited(item)) next(context);
      break;
    case MavCmd::kNavLoiterUnlim:
      if (!reached(context)) break;
      if (waited_s_ == 0) reached_ = static_cast<std::uint16_t>(current_);
      waited_s_ += context.dt;
      break;
    case MavCmd::kNavLand:
      if (reached(context) && mover_.arrived()) touch_down(context);
      break;
    case MavCmd::kNavReturnToLaunch:
      break;
    default:
      next(context);
  }
}

/// The item's wait, param 1 in s, is over; NaN is no wait.
bool MissionTask::waited(const MissionItem& item) const { return !(waited_s_ < item.param[0]); }

void MissionTask::touch_down(const TaskContext& context) {
  landing_ = true;
  reached_ = static_cast<std::uint16_t>(current_);
  land_.activate(context);
}

}  // namespace cas::fcu
