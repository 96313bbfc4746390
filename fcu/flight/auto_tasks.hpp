// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "fcu/flight/flight_task.hpp"
#include "fcu/flight/pattern.hpp"

namespace cas::fcu {

/// Stays, or goes to a place and stays there; flies a built-in pattern about it.
class HoldTask final : public FlightTask {
 public:
  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  void shift(const Eigen::Vector3d& by_N) override;
  bool done(const TaskContext&) const override { return mover_.arrived(); }

  /// Goes to a place; components that are NaN stay as they are.
  void go_to(const Eigen::Vector3d& p_N, double yaw_rad, double speed_m_s);
  /// Flies a pattern about the present target until the next go_to.
  void fly_pattern(PatternShape shape, double size_m, double speed_m_s, double period_s);
  /// Stays at a place that the vehicle is at (the end of what another task did).
  void settle(const Eigen::Vector3d& p_N, double yaw_rad);
  const Eigen::Vector3d& target() const { return mover_.target(); }

 private:
  Mover mover_;
  double speed_m_s_ = -1;  ///< below zero: cruise speed
  std::optional<Pattern> pattern_;
  double pattern_time_s_ = 0;
  Eigen::Vector3d pattern_centre_N_ = Eigen::Vector3d::Zero();
  int pattern_param_ = 0;
};

/// Climbs straight up from where it stands.
class TakeoffTask final : public FlightTask {
 public:
  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  void shift(const Eigen::Vector3d& by_N) override { mover_.shift(by_N); }
  bool done(const TaskContext& context) const override;
  bool wants_takeoff(const TaskContext&) const override { return true; }

  /// Height to climb to: z (down) in N. Without one, MIS_TAKEOFF_ALT above the ground.
  void set_target_z(std::optional<double> z) { wanted_z_ = z; }
  void set_yaw(double yaw_rad) { wanted_yaw_ = yaw_rad; }
  const Eigen::Vector3d& target() const { return mover_.target(); }
  double yaw() const { return mover_.target_yaw(); }

 private:
  void aim(const TaskContext& context);

  Mover mover_;
  std::optional<double> wanted_z_;
  double wanted_yaw_ = kUnset;
  bool clear_ = false;  ///< of the ground
};

/// Descends on the spot until the ground is there; level when there is no position.
class LandTask final : public FlightTask {
 public:
  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  void shift(const Eigen::Vector3d& by_N) override { mover_.shift(by_N); }
  bool descending(const TaskContext&) const override { return true; }

 private:
  Mover mover_;
  double speed_m_s_ = 0;
};

/// Climbs to the return height, flies home, descends, lands.
class ReturnTask final : public FlightTask {
 public:
  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  void shift(const Eigen::Vector3d& by_N) override;
  bool descending(const TaskContext&) const override { return stage_ == Stage::kLand; }

 private:
  enum class Stage { kClimb, kCruise, kDescend, kWait, kLand };
  void enter(Stage stage, const TaskContext& context);

  Stage stage_ = Stage::kClimb;
  Mover mover_;
  LandTask land_;
  double waited_s_ = 0;
};

}  // namespace cas::fcu
