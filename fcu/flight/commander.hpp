// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>

#include "fcu/flight/arming_checks.hpp"
#include "fcu/flight/auto_tasks.hpp"
#include "fcu/flight/failsafe.hpp"
#include "fcu/flight/flight_status.hpp"
#include "fcu/flight/flight_task.hpp"
#include "fcu/flight/land_detector.hpp"
#include "fcu/flight/manual_task.hpp"
#include "fcu/flight/mission_task.hpp"
#include "fcu/flight/offboard_task.hpp"
#include "fcu/flight/status_texts.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::fcu {

/// Who asked for a change of state.
enum class Initiator { kCommand, kFailsafe, kInternal };

/// Arms and disarms, holds the mode, decides which task flies, takes off and lands, and acts when
/// something is lost.
///
///            arm                spool-up, task wants up          touchdown
///   disarmed ---> armed, idle ----------------------> flying ------------> armed, idle --->
///   disarmed
class Commander {
 public:
  using Result = mavlink::common::MavResult;

  explicit Commander(StatusTexts& texts) : texts_(texts) {}

  // Requests, answered at once.
  Result arm(const ArmingInput& checks, const TaskContext& context, bool force);
  Result disarm(bool force);
  Result set_mode(FlightMode mode, const TaskContext& context, Initiator initiator);
  Result take_off(std::optional<double> z, double yaw_rad, const TaskContext& context);
  /// Goes to a place in Hold, changing to Hold when `change_mode`.
  Result reposition(const Eigen::Vector3d& p_N, double yaw_rad, double speed_m_s, bool change_mode,
                    const TaskContext& context);
  Result fly_pattern(PatternShape shape, double size_m, double speed_m_s, double period_s,
                     const TaskContext& context);
  void terminate(const std::string& reason);

  /// One control step.
  ControlSetpoint update(const TaskContext& context, const FailsafeInput& failsafe,
                         double thrust_ratio);
  /// The estimate was moved by this much.
  void on_position_reset(const Eigen::Vector3d& by_N);
  /// No sensor data: the control step that would notice does not come.
  void on_sensors_lost();

  bool armed() const { return armed_; }
  FlightMode mode() const { return mode_; }
  LandedState landed() const;
  bool flying() const { return flying_; }
  bool failsafe_active() const { return failsafe_.active(); }
  OffboardTask& offboard() { return offboard_; }
  MissionTask& mission() { return mission_; }
  const MissionTask& mission() const { return mission_; }
  /// Position reference of the running task, m (NaN where none).
  const ControlSetpoint& setpoint() const { return setpoint_; }

 private:
  FlightTask& task(FlightMode mode);
  void enter(FlightMode mode, const TaskContext& context);
  void act(const FailsafeDecision& decision, const TaskContext& context);
  void update_flying(const TaskContext& context, double thrust_ratio);
  void settle_on_ground(const TaskContext& context);
  void finish_tasks(const TaskContext& context);
  void auto_disarm(const TaskContext& context);
  void set_disarmed(const std::string& why);

  StatusTexts& texts_;
  bool armed_ = false;
  bool flying_ = false;
  bool contact_ = false;
  bool may_take_off_ = true;  ///< after a landing only a new request lifts an automatic mode
  FlightMode mode_ = FlightMode::kHold;
  double armed_s_ = 0;
  double landed_s_ = 0;
  bool has_flown_ = false;
  HoldTask hold_;
  TakeoffTask takeoff_;
  LandTask land_;
  ReturnTask return_;
  OffboardTask offboard_;
  ManualTask stabilized_{FlightMode::kStabilized};
  ManualTask altitude_{FlightMode::kAltitude};
  ManualTask position_{FlightMode::kPosition};
  MissionTask mission_;
  LandDetector land_detector_;
  double contact_thrust_ = 1;  ///< over hover, on the way down to nothing
  Failsafe failsafe_;
  ControlSetpoint setpoint_;
};

}  // namespace cas::fcu
