// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/earth/geodesy.hpp"
#include "base/time/clock.hpp"
#include "fcu/control/airspeed.hpp"
#include "fcu/control/setpoint.hpp"
#include "fcu/control/wing_params.hpp"
#include "fcu/estimation/estimator.hpp"
#include "fcu/flight/flight_status.hpp"
#include "fcu/flight/trajectory.hpp"
#include "fcu/params/settings.hpp"

namespace cas::fcu {

/// Stick positions, -1..1; throttle 0..1.
struct Sticks {
  double roll = 0;
  double pitch = 0;  ///< positive: nose down, forward
  double yaw = 0;
  double throttle = 0.5;
};

/// Input of a flight mode at one control step.
struct TaskContext {
  EstimatorState estimate;
  double yaw_rad = 0;  ///< estimated heading
  bool position_valid = false;
  bool height_valid = false;
  FlightParams params;
  Eigen::Vector3d home_N = Eigen::Vector3d::Zero();  ///< m
  double home_yaw_rad = 0;                           ///< heading when home was set
  double ground_z = 0;  ///< z (down) of the ground at the take-off place, m
  std::optional<base::LocalProjection> projection;
  std::optional<Sticks> sticks;  ///< nothing while no pilot is heard
  double full_thrust_n = 0;      ///< U1 at throttle 1
  WingParams wing;               ///< of a vehicle with a wing
  Airspeed airspeed;             ///< the same
  base::RunTime now;
  double dt = 0;  ///< s since the last control step
};

/// One way to fly: from the estimate to a setpoint. Tasks neither arm nor change the mode.
class FlightTask {
 public:
  virtual ~FlightTask() = default;
  /// Takes over from whatever flew before.
  virtual void activate(const TaskContext& context) = 0;
  /// Setpoint of this control step.
  virtual ControlSetpoint update(const TaskContext& context) = 0;
  /// The estimate was moved by this much, m.
  virtual void shift(const Eigen::Vector3d& by_N) { static_cast<void>(by_N); }
  /// The task is finished.
  virtual bool done(const TaskContext&) const { return false; }
  /// Wants the vehicle on the ground to leave it.
  virtual bool wants_takeoff(const TaskContext&) const { return false; }
  /// Is going down: a landing is expected.
  virtual bool descending(const TaskContext&) const { return false; }
};

/// The limits of the automatic modes.
MoverLimits mover_limits(const FlightParams& params);

/// A task that leads its setpoint from one target to the next.
class MovingTask : public FlightTask {
 public:
  void shift(const Eigen::Vector3d& by_N) final {
    mover_.shift(by_N);
    shift_more(by_N);
  }
  const Eigen::Vector3d& target() const { return mover_.target(); }
  double yaw() const { return mover_.target_yaw(); }

 protected:
  Mover mover_;

 private:
  /// The places that the task keeps beside the mover's.
  virtual void shift_more(const Eigen::Vector3d& by_N) { static_cast<void>(by_N); }
};

/// Stays, or goes to a place and stays there; flies a built-in pattern about it.
class HoldTask final : public MovingTask {
 public:
  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  bool done(const TaskContext&) const override { return mover_.arrived(); }

  /// Goes to a place; components that are NaN stay as they are.
  void go_to(const Eigen::Vector3d& p_N, double yaw_rad, double speed_m_s);
  /// Flies a pattern about the present target until the next go_to.
  void fly_pattern(PatternShape shape, double size_m, double speed_m_s, double period_s);
  /// Holds the vehicle's present place (the end of another task).
  void settle(const Eigen::Vector3d& p_N, double yaw_rad);

 private:
  void shift_more(const Eigen::Vector3d& by_N) override { pattern_centre_N_ += by_N; }

  double speed_m_s_ = -1;  ///< below zero: cruise speed
  std::optional<Pattern> pattern_;
  double pattern_time_s_ = 0;
  Eigen::Vector3d pattern_centre_N_ = Eigen::Vector3d::Zero();
  int pattern_param_ = 0;
};

/// Climbs straight up from the ground.
class TakeoffTask final : public MovingTask {
 public:
  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  bool done(const TaskContext& context) const override;
  bool wants_takeoff(const TaskContext&) const override { return true; }

  /// Height to climb to: z (down) in N. Without one, MIS_TAKEOFF_ALT above the ground, as it is
  /// when the mode begins: who has written it for this takeoff may restore it during the climb.
  void set_target_z(std::optional<double> z) { wanted_z_ = z; }
  void set_yaw(double yaw_rad) { wanted_yaw_ = yaw_rad; }

 private:
  void aim(const TaskContext& context);

  std::optional<double> wanted_z_;
  double usual_height_m_ = 0;
  double wanted_yaw_ = kUnset;
  bool clear_ = false;  ///< of the ground
};

/// Descends on the spot until the ground is there; level when there is no position.
class LandTask final : public MovingTask {
 public:
  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  bool descending(const TaskContext&) const override { return true; }

 private:
  double speed_m_s_ = 0;
};

/// Climbs to the return height, flies home, descends, lands.
class ReturnTask final : public MovingTask {
 public:
  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  bool descending(const TaskContext&) const override { return stage_ == Stage::kLand; }

 private:
  enum class Stage { kClimb, kCruise, kDescend, kWait, kLand };
  void shift_more(const Eigen::Vector3d& by_N) override { land_.shift(by_N); }
  void enter(Stage stage, const TaskContext& context);

  Stage stage_ = Stage::kClimb;
  LandTask land_;
  double waited_s_ = 0;
};

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

/// Follows a companion's stream of trajectory setpoints or attitudes. A silent stream triggers a
/// failsafe; until then the last setpoint is held.
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
