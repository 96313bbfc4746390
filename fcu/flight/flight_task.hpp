// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/earth/geodesy.hpp"
#include "base/time/clock.hpp"
#include "fcu/control/setpoint.hpp"
#include "fcu/estimation/estimator.hpp"
#include "fcu/flight/flight_mode.hpp"
#include "fcu/flight/mover.hpp"
#include "fcu/params/param_binding.hpp"

namespace cas::fcu {

/// Stick positions, -1..1; throttle 0..1.
struct Sticks {
  double roll = 0;
  double pitch = 0;  ///< positive: nose down, forward
  double yaw = 0;
  double throttle = 0.5;
};

/// What a flight mode sees at one control step.
struct TaskContext {
  EstimatorState estimate;
  double yaw_rad = 0;  ///< estimated heading
  bool position_valid = false;
  bool height_valid = false;
  FlightParams params;
  Eigen::Vector3d home_N = Eigen::Vector3d::Zero();  ///< m
  double ground_z = 0;  ///< z (down) of the ground at the take-off place, m
  std::optional<base::LocalProjection> projection;
  std::optional<Sticks> sticks;  ///< nothing while no pilot is heard
  double full_thrust_n = 0;      ///< U1 at throttle 1
  base::RunTime now;
  double dt = 0;  ///< s since the last control step
};

/// One way to fly: from the estimate to a setpoint. Tasks neither arm nor change the mode.
class FlightTask {
 public:
  virtual ~FlightTask() = default;
  /// Takes over from whatever flew before.
  virtual void activate(const TaskContext& context) = 0;
  /// What to follow in this control step.
  virtual ControlSetpoint update(const TaskContext& context) = 0;
  /// The estimate was moved by this much, m.
  virtual void shift(const Eigen::Vector3d& by_N) { static_cast<void>(by_N); }
  /// Has done what it was there for.
  virtual bool done(const TaskContext&) const { return false; }
  /// Wants the vehicle on the ground to leave it.
  virtual bool wants_takeoff(const TaskContext&) const { return false; }
  /// Wants down: landing is expected.
  virtual bool descending(const TaskContext&) const { return false; }
};

/// The limits of the automatic modes.
MoverLimits mover_limits(const FlightParams& params);

}  // namespace cas::fcu
