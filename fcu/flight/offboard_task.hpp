// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "fcu/flight/flight_task.hpp"

namespace cas::fcu {

/// Follows what a companion streams: trajectory setpoints or attitudes. A stream that falls silent
/// is a failsafe; the last setpoint is held until then.
class OffboardTask final : public FlightTask {
 public:
  /// Takes a setpoint; given again and again, before the mode can be entered and while it lasts.
  void on_trajectory(const TrajectorySetpoint& setpoint, base::RunTime now);
  void on_attitude(const AttitudeSetpoint& setpoint, base::RunTime now);
  bool alive(base::RunTime now, double timeout_s) const;

  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  bool wants_takeoff(const TaskContext& context) const override;
  bool descending(const TaskContext& context) const override;

 private:
  std::optional<TrajectorySetpoint> trajectory_;
  std::optional<AttitudeSetpoint> attitude_;
  base::RunTime last_;
  bool heard_ = false;
  double yaw_rad_ = 0;
};

}  // namespace cas::fcu
