// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/body/obstacle_path.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cas::sim {

namespace {

BodyState standing(const Eigen::Isometry3d& pose) {
  BodyState state;
  state.p_WB = pose.translation();
  state.q_WB = Eigen::Quaterniond(pose.linear());
  return state;
}

}  // namespace

ObstaclePath::ObstaclePath(std::vector<Waypoint> waypoints, bool loop, double delay_s)
    : waypoints_(std::move(waypoints)), loop_(loop), delay_s_(delay_s) {}

BodyState ObstaclePath::at(double time_s) const {
  const double begin = waypoints_.front().time_s;
  const double length = waypoints_.back().time_s - begin;
  double t = time_s - delay_s_;
  if (loop_ && length > 0 && t > begin) t = begin + std::fmod(t - begin, length);
  const auto next =
      std::upper_bound(waypoints_.begin(), waypoints_.end(), t,
                       [](double time, const Waypoint& w) { return time < w.time_s; });
  if (next == waypoints_.begin()) return standing(waypoints_.front().pose);
  if (next == waypoints_.end()) return standing(waypoints_.back().pose);
  const Waypoint& from = *(next - 1);
  const Waypoint& to = *next;
  const double dt = to.time_s - from.time_s;
  const double share = (t - from.time_s) / dt;
  const Eigen::Quaterniond q_from(from.pose.linear());
  const Eigen::Quaterniond q_to(to.pose.linear());
  const Eigen::Vector3d way = to.pose.translation() - from.pose.translation();
  const Eigen::AngleAxisd turn(q_from.conjugate() * q_to);  // 0 to pi: the shorter way

  BodyState state;
  state.p_WB = from.pose.translation() + share * way;
  state.q_WB = q_from.slerp(share, q_to);
  state.v_WB = way / dt;
  state.w_WB_B = turn.axis() * (turn.angle() / dt);  // the axis is the same in both attitudes
  return state;
}

}  // namespace cas::sim
