// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "base/time/clock.hpp"
#include "fcu/estimation/estimator.hpp"
#include "fcu/estimation/sensor_health.hpp"
#include "fcu/flight/failsafe.hpp"
#include "fcu/flight/flight_status.hpp"
#include "fcu/flight/flight_tasks.hpp"
#include "fcu/flight/mission_task.hpp"
#include "fcu/flight/status_texts.hpp"
#include "fcu/flight/vtol_transition.hpp"
#include "fcu/flight/wing_task.hpp"
#include "fcu/params/settings.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::fcu {

/// Inputs of the arming checks.
struct ArmingInput {
  const Estimator& estimator;
  const SensorHealth& sensors;
  const FlightParams& params;
  FlightMode mode;
  bool has_sticks = false;
  double sticks_throttle = 0;         ///< 0..1
  std::optional<double> battery = 1;  ///< 0..1 of full; nullopt: unknown
  base::RunTime now;
};

/// The first failed arming check, in words; nullopt when all pass.
std::optional<std::string> reason_not_to_arm(const ArmingInput& in);

/// Thrust over the thrust in hover.
struct ThrustRatio {
  double given = 1;   ///< of the rotors; roll and pitch may raise it
  double wanted = 1;  ///< of the setpoint
};

/// Detects that the vehicle is on the ground, in two steps.
///
/// Contact: wants down, does not go down, and thrust is already low, or has been wanted low for a
/// second: rotors that are lost unnoticed, or a moment, may keep it up. Then it is taken away.
/// Landed: with a third of the hover thrust and less nothing moves. In the air either would make
/// the vehicle fall, which ends the suspicion.
class LandDetector {
 public:
  /// How sure it is.
  enum class Stage { kAir, kContact, kLanded };

  /// Measurements of one control step.
  struct Input {
    ThrustRatio thrust;
    double vertical_speed_m_s = 0;  ///< down, of the estimate
    double horizontal_speed_m_s = 0;
    bool descending = false;  ///< the setpoint wants down (or nothing)
  };

  void reset() { *this = LandDetector{}; }

  /// @param dt  s
  Stage update(const Input& in, double dt) {
    constexpr double kVerticalSpeed_m_s = 0.3;
    constexpr double kHorizontalSpeed_m_s = 1.0;
    const bool still = in.descending && -kVerticalSpeed_m_s < in.vertical_speed_m_s &&
                       in.vertical_speed_m_s < kVerticalSpeed_m_s &&
                       in.horizontal_speed_m_s < kHorizontalSpeed_m_s;
    unheeded_s_ = still && in.thrust.wanted < kContactThrust ? unheeded_s_ + dt : 0;
    const bool low = in.thrust.given < kContactThrust || unheeded_s_ > kUnheededTime_s;
    const bool suspected = still && (contact_s_ > kContactTime_s || low);
    contact_s_ = suspected ? contact_s_ + dt : 0;
    landed_s_ = suspected && in.thrust.given < kLandedThrust ? landed_s_ + dt : 0;
    if (landed_s_ > kLandedTime_s) return Stage::kLanded;
    return contact_s_ > kContactTime_s ? Stage::kContact : Stage::kAir;
  }

 private:
  static constexpr double kContactThrust = 0.75;
  static constexpr double kContactTime_s = 0.25;
  static constexpr double kUnheededTime_s = 1.0;
  static constexpr double kLandedThrust = 0.35;
  static constexpr double kLandedTime_s = 0.3;
  double unheeded_s_ = 0;
  double contact_s_ = 0;
  double landed_s_ = 0;
};

/// Originator of a change of mode.
enum class Initiator { kCommand, kFailsafe };

/// Arms and disarms, holds the mode, decides which task flies, takes off and lands, and acts when
/// something is lost.
///
///            arm                spool-up, task wants up          touchdown
///   disarmed ---> armed, idle ----------------------> flying ------------> armed, idle --->
///   disarmed
class Commander {
 public:
  using Result = mavlink::common::MavResult;

  Commander(StatusTexts& texts, const base::Vehicle& vehicle)
      : texts_(texts), airframe_(airframe_kind(vehicle)), vtol_(vehicle) {}

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
  /// Circles about a place on the wing; a component or radius that is NaN stays as it is.
  Result circle(const Eigen::Vector3d& middle_N, double radius_m, const TaskContext& context);
  /// Turns a VTOL into a plane, or back.
  Result transition(bool to_plane, const TaskContext& context);
  void terminate(const std::string& reason);

  /// One control step.
  ControlSetpoint update(const TaskContext& context, const FailsafeInput& failsafe,
                         const ThrustRatio& thrust);
  /// The estimate was moved by this much.
  void on_position_reset(const Eigen::Vector3d& by_N);
  /// No gyro and accelerometer: the control step that would notice may not come.
  void on_sensors_lost(const std::string& what);

  bool armed() const { return armed_; }
  FlightMode mode() const { return mode_; }
  LandedState landed() const;
  bool flying() const { return flying_; }
  AirframeKind airframe() const { return airframe_; }
  /// What carries it; of a VTOL.
  VtolState vtol_state() const { return vtol_.state(); }
  /// Flies on its wing alone.
  bool on_wing() const {
    return airframe_ == AirframeKind::kPlane ||
           (airframe_ == AirframeKind::kVtol && vtol_.state() == VtolState::kPlane);
  }
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
  void update_flying(const TaskContext& context, const ThrustRatio& thrust);
  void update_transition(const TaskContext& context);
  void touch_ground();
  void give_up_takeoff(const TaskContext& context);
  void settle_on_ground(const TaskContext& context);
  void finish_tasks(const TaskContext& context);
  void auto_disarm(const TaskContext& context);
  void set_disarmed(const std::string& why);

  StatusTexts& texts_;
  AirframeKind airframe_;
  VtolTransition vtol_;
  bool armed_ = false;
  bool flying_ = false;
  bool contact_ = false;
  bool may_take_off_ = true;  ///< after a landing only a new request lifts an automatic mode
  FlightMode mode_ = FlightMode::kHold;
  double armed_s_ = 0;
  double landed_s_ = 0;
  bool has_flown_ = false;
  bool has_climbed_ = false;
  double climbing_s_ = 0;  ///< since the start of a take-off
  HoldTask hold_;
  TakeoffTask takeoff_;
  LandTask land_;
  ReturnTask return_;
  OffboardTask offboard_;
  ManualTask stabilized_{FlightMode::kStabilized};
  ManualTask altitude_{FlightMode::kAltitude};
  ManualTask position_{FlightMode::kPosition};
  MissionTask mission_;
  WingTask wing_;
  LandDetector land_detector_;
  double contact_thrust_ = 1;  ///< over hover, on the way down to nothing
  Failsafe failsafe_;
  ControlSetpoint setpoint_;
};

}  // namespace cas::fcu
