// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "fcu/flight/flight_task.hpp"

namespace cas::fcu {

/// Flown by sticks: tilt and thrust (Stabilized), tilt and climb rate (Altitude), or velocity with
/// a hold when the sticks are centred (Position).
class ManualTask final : public FlightTask {
 public:
  explicit ManualTask(FlightMode mode) : mode_(mode) {}

  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  void shift(const Eigen::Vector3d& by_N) override { p_N_ += by_N; }
  bool wants_takeoff(const TaskContext& context) const override;
  bool descending(const TaskContext& context) const override;

 private:
  ControlSetpoint stabilized(const Sticks& sticks, const TaskContext& context);
  double climb(const Sticks& sticks, const TaskContext& context) const;
  void hold_height(double climb_m_s, const TaskContext& context, TrajectorySetpoint& out);

  FlightMode mode_;
  Eigen::Vector3d p_N_ = Eigen::Vector3d::Zero();  ///< position led by the sticks
  Eigen::Vector3d v_N_ = Eigen::Vector3d::Zero();
  double yaw_rad_ = 0;
};

}  // namespace cas::fcu
