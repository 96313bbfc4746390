// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/setpoint_stream.hpp"

#include <algorithm>

namespace cas::hils {
namespace {

using mavlink::common::PositionTargetTypemask;

/// A pause of this length ends a stream (PX4: COM_OF_LOSS_T is 1 s, 500 ms to enter OFFBOARD).
constexpr base::Duration kAlive = std::chrono::milliseconds(500);

constexpr PositionTargetTypemask kPositionVelocityYaw =
    PositionTargetTypemask::kAxIgnore | PositionTargetTypemask::kAyIgnore |
    PositionTargetTypemask::kAzIgnore | PositionTargetTypemask::kYawRateIgnore;

}  // namespace

void SetpointStream::hover(const Eigen::Vector3d& p_N, double yaw_rad) {
  on_ = true;
  centre_N_ = p_N;
  yaw_rad_ = yaw_rad;
  pattern_.reset();
  line_.reset();
}

void SetpointStream::fly(const fcu::Pattern& pattern, base::Duration vehicle_time) {
  pattern_ = pattern;
  begin_ = vehicle_time;
}

void SetpointStream::fly_to(const Eigen::Vector3d& p_N, double speed_m_s,
                            base::Duration vehicle_time) {
  line_ = Line{p_N, speed_m_s};
  begin_ = vehicle_time;
}

void SetpointStream::stop() {
  on_ = false;
  began_.reset();
}

fcu::TrajectorySetpoint SetpointStream::at(base::Duration vehicle_time) const {
  const double seconds = base::to_seconds(vehicle_time - begin_);
  if (pattern_) return pattern_->at(seconds, centre_N_, yaw_rad_);
  if (line_) return on_line(seconds);
  return {centre_N_, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), yaw_rad_, 0};
}

fcu::TrajectorySetpoint SetpointStream::on_line(double seconds) const {
  const Eigen::Vector3d way_N = line_->end_N - centre_N_;
  const double gone_m = seconds * line_->speed_m_s;
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  if (gone_m >= way_N.norm()) return {line_->end_N, zero, zero, yaw_rad_, 0};
  const Eigen::Vector3d ahead_N = way_N.normalized();
  return {centre_N_ + gone_m * ahead_N, line_->speed_m_s * ahead_N, zero, yaw_rad_, 0};
}

std::optional<mavlink::common::SetPositionTargetLocalNed> SetpointStream::update(
    base::Duration vehicle_time) {
  if (!on_ || !gate_.due(vehicle_time)) return std::nullopt;
  if (began_) {
    const base::Duration gap = vehicle_time - newest_;
    figures_.longest_gap_s = std::max(figures_.longest_gap_s, base::to_seconds(gap));
    if (gap > kAlive) began_.reset();
  }
  if (!began_) began_ = vehicle_time;
  newest_ = vehicle_time;
  ++figures_.count;
  const fcu::TrajectorySetpoint setpoint = at(vehicle_time);
  mavlink::common::SetPositionTargetLocalNed message;
  message.time_boot_ms = static_cast<std::uint32_t>(vehicle_time / std::chrono::milliseconds(1));
  message.coordinate_frame = mavlink::common::MavFrame::kLocalNed;
  message.type_mask = kPositionVelocityYaw;
  message.x = static_cast<float>(setpoint.p_N.x());
  message.y = static_cast<float>(setpoint.p_N.y());
  message.z = static_cast<float>(setpoint.p_N.z());
  message.vx = static_cast<float>(setpoint.v_N.x());
  message.vy = static_cast<float>(setpoint.v_N.y());
  message.vz = static_cast<float>(setpoint.v_N.z());
  message.yaw = static_cast<float>(setpoint.yaw_rad);
  return message;
}

}  // namespace cas::hils
