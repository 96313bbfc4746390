// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/commander.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::fcu {

using Result = Commander::Result;

// Arming checks.

std::optional<std::string> reason_not_to_arm(const ArmingInput& in) {
  using M = SensorHealth;
  constexpr double kTilt_rad = 0.35;
  constexpr double kThrottleUp = 0.6;
  if (!in.sensors.alive(M::kImu, in.now)) return "no accelerometer and gyro data";
  if (!in.sensors.alive(M::kMag, in.now)) return "no compass data";
  if (!in.sensors.alive(M::kBaro, in.now)) return "no barometer data";
  if (!in.estimator.aligned()) return "attitude estimate not aligned";
  const Eigen::Vector3d rpy = base::euler_rpy(in.estimator.state().q_ND);
  if (std::hypot(rpy.x(), rpy.y()) > kTilt_rad) return "vehicle is tilted";
  const bool gps_needed = needs_position(in.mode) || !in.params.arm_without_gps;
  if (gps_needed) {
    const bool has_odometry = in.sensors.alive(M::kOdometry, in.now);
    if (in.sensors.gps_frozen() && !has_odometry) return "GPS repeats its last fix";
    if (!in.sensors.alive(M::kGps, in.now) && !has_odometry) return "no GPS data";
    if (in.estimator.gps_contradicts_itself()) return "GPS velocity contradicts position";
    if (!in.estimator.heading_valid()) return "heading estimate not valid";
    if (!in.estimator.position_valid()) return "position estimate not valid";
    if (!in.estimator.origin_final()) return "waiting for the position estimate to settle";
  }
  if (!in.battery) return "no battery data";
  if (*in.battery < in.params.battery_critical) return "battery low";
  if (is_manual(in.mode)) {
    if (!in.has_sticks) return "no manual control";
    if (in.sticks_throttle > kThrottleUp) return "throttle is not low";
  }
  if (in.mode == FlightMode::kTermination) return "flight was terminated; reboot";
  return std::nullopt;
}

FlightTask& Commander::task(FlightMode mode) {
  if (on_wing()) return wing_;
  switch (mode) {
    case FlightMode::kStabilized:
      return stabilized_;
    case FlightMode::kAltitude:
      return altitude_;
    case FlightMode::kPosition:
      return position_;
    case FlightMode::kOffboard:
      return offboard_;
    case FlightMode::kTakeoff:
      return takeoff_;
    case FlightMode::kMission:
      return mission_;
    case FlightMode::kReturn:
      return return_;
    case FlightMode::kLand:
      return land_;
    case FlightMode::kHold:
    case FlightMode::kTermination:
      return hold_;
  }
  return hold_;
}

// Requests.

namespace {

/// Modes of sticks, companions and missions are the rotors'.
bool flies_on_wing(FlightMode mode) {
  return mode == FlightMode::kTakeoff || mode == FlightMode::kHold || mode == FlightMode::kReturn ||
         mode == FlightMode::kLand;
}

}  // namespace

Result Commander::arm(const ArmingInput& checks, const TaskContext& context, bool force) {
  if (armed_) return Result::kAccepted;
  if (mode_ == FlightMode::kTermination) {
    texts_.critical("Arming denied: flight was terminated; reboot");
    return Result::kTemporarilyRejected;
  }
  if (const auto reason = reason_not_to_arm(checks); reason && !force) {
    texts_.critical("Arming denied: " + *reason);
    return Result::kTemporarilyRejected;
  }
  armed_ = true;
  flying_ = false;
  has_flown_ = false;
  armed_s_ = landed_s_ = 0;
  failsafe_.reset();
  enter(mode_, context);
  texts_.info("Armed");
  return Result::kAccepted;
}

void Commander::set_disarmed(const std::string& why) {
  armed_ = false;
  flying_ = false;
  vtol_.reset();
  failsafe_.reset();
  texts_.info("Disarmed" + why);
  if (mode_ != FlightMode::kTermination && !is_manual(mode_)) mode_ = FlightMode::kHold;
}

Result Commander::disarm(bool force) {
  if (!armed_) return Result::kAccepted;
  if (flying_ && !force) {
    texts_.critical("Disarming denied: not landed");
    return Result::kTemporarilyRejected;
  }
  set_disarmed(force && flying_ ? " in the air by force" : "");
  return Result::kAccepted;
}

Result Commander::set_mode(FlightMode mode, const TaskContext& context, Initiator initiator) {
  if (mode_ == FlightMode::kTermination) return Result::kTemporarilyRejected;
  const auto refuse = [this](const std::string& why) {
    texts_.critical("Mode change refused: " + why);
    return Result::kTemporarilyRejected;
  };
  if (armed_ && needs_position(mode) && !context.position_valid) {
    return refuse("no position estimate");
  }
  if (mode == FlightMode::kOffboard && !offboard_.alive(context.now, 0.5)) {
    return refuse("no offboard setpoints");
  }
  if (mode == FlightMode::kMission && mission_.items().empty()) return refuse("no mission");
  if (on_wing() && !flies_on_wing(mode)) return refuse("not on the wing");
  if (is_manual(mode) && armed_ && !context.sticks) return refuse("no manual control");
  if (initiator == Initiator::kCommand) failsafe_.reset();
  if (mode != mode_ || mode == FlightMode::kTakeoff) enter(mode, context);
  return Result::kAccepted;
}

Result Commander::take_off(std::optional<double> z, double yaw_rad, const TaskContext& context) {
  if (flying_) {
    texts_.warn("Already in the air");
    return Result::kTemporarilyRejected;
  }
  if (z && *z > context.ground_z - 0.1) {
    texts_.critical("Take-off altitude is below the vehicle");
    return Result::kDenied;
  }
  takeoff_.set_target_z(z);
  wing_.set_takeoff_z(z);
  takeoff_.set_yaw(yaw_rad);
  return set_mode(FlightMode::kTakeoff, context, Initiator::kCommand);
}

Result Commander::reposition(const Eigen::Vector3d& p_N, double yaw_rad, double speed_m_s,
                             bool change_mode, const TaskContext& context) {
  if (!flying_) {
    texts_.critical("Reposition refused: not in the air");
    return Result::kTemporarilyRejected;
  }
  if (mode_ != FlightMode::kHold) {
    if (!change_mode) return Result::kTemporarilyRejected;
    const Result result = set_mode(FlightMode::kHold, context, Initiator::kCommand);
    if (result != Result::kAccepted) return result;
  }
  if (on_wing()) {
    wing_.circle(p_N, kUnset);
  } else {
    hold_.go_to(p_N, yaw_rad, speed_m_s);
  }
  return Result::kAccepted;
}

Result Commander::circle(const Eigen::Vector3d& middle_N, double radius_m,
                         const TaskContext& context) {
  if (!flying_) return Result::kTemporarilyRejected;
  const Result result = set_mode(FlightMode::kHold, context, Initiator::kCommand);
  if (result == Result::kAccepted) wing_.circle(middle_N, radius_m);
  return result;
}

Result Commander::transition(bool to_plane, const TaskContext& context) {
  if (airframe_ != AirframeKind::kVtol) return Result::kUnsupported;
  const bool steady = mode_ == FlightMode::kHold || mode_ == FlightMode::kReturn;
  if (!flying_ || !steady) {
    texts_.critical("Transition refused: it begins in Hold, in the air");
    return Result::kTemporarilyRejected;
  }
  vtol_.begin(to_plane, context);
  return Result::kAccepted;
}

Result Commander::fly_pattern(PatternShape shape, double size_m, double speed_m_s, double period_s,
                              const TaskContext& context) {
  if (!flying_) return Result::kTemporarilyRejected;
  const Result result = set_mode(FlightMode::kHold, context, Initiator::kCommand);
  if (result == Result::kAccepted) hold_.fly_pattern(shape, size_m, speed_m_s, period_s);
  return result;
}

void Commander::terminate(const std::string& reason) {
  texts_.add(StatusTexts::Severity::kEmergency, reason);
  mode_ = FlightMode::kTermination;
  if (armed_) set_disarmed("");
}

// Flight.

void Commander::enter(FlightMode mode, const TaskContext& context) {
  mode_ = mode;
  may_take_off_ = true;
  land_detector_.reset();
  wing_.set_mode(mode);
  task(mode).activate(context);
}

void Commander::act(const FailsafeDecision& decision, const TaskContext& context) {
  if (decision.reason.empty()) return;
  using Action = FailsafeDecision::Action;
  if (decision.action == Action::kTerminate) return terminate(decision.reason);
  texts_.add(
      decision.warning_only ? StatusTexts::Severity::kWarning : StatusTexts::Severity::kCritical,
      decision.reason);
  if (decision.action == Action::kDisarm) return set_disarmed(" by failsafe");
  if (decision.action != Action::kMode) return;
  if (set_mode(decision.mode, context, Initiator::kFailsafe) != Result::kAccepted) {
    enter(FlightMode::kLand, context);
  }
}

void Commander::update_flying(const TaskContext& context, const ThrustRatio& thrust) {
  FlightTask& now = task(mode_);
  if (!flying_) {
    if (!may_take_off_ || armed_s_ < context.params.spool_up_s || !now.wants_takeoff(context)) {
      return;
    }
    flying_ = true;
    contact_ = false;
    has_flown_ = true;
    has_climbed_ = false;
    climbing_s_ = 0;
    land_detector_.reset();
    now.activate(context);
    return;
  }
  if (on_wing()) {
    if (wing_.landed()) touch_ground();
    return;
  }
  const Eigen::Vector3d& v = context.estimate.v_N;
  const LandDetector::Input in{thrust, v.z(), v.head<2>().norm(), now.descending(context)};
  const LandDetector::Stage stage = land_detector_.update(in, context.dt);
  if (stage == LandDetector::Stage::kContact && !contact_) contact_thrust_ = thrust.given;
  contact_ = stage == LandDetector::Stage::kContact;
  if (stage == LandDetector::Stage::kLanded) touch_ground();
}

void Commander::touch_ground() {
  flying_ = false;
  may_take_off_ = is_manual(mode_) || mode_ == FlightMode::kOffboard;
  landed_s_ = 0;
  vtol_.reset();
  texts_.info("Landed");
}

/// Steps the transition. A VTOL that lands or returns is turned into a multicopter first.
void Commander::update_transition(const TaskContext& context) {
  if (airframe_ != AirframeKind::kVtol || !flying_) return;
  const bool lands = mode_ == FlightMode::kLand || mode_ == FlightMode::kReturn;
  const bool flies_on = vtol_.state() == VtolState::kPlane || vtol_.state() == VtolState::kToPlane;
  if (lands && flies_on) vtol_.begin(false, context);
  if (!vtol_.under_way()) return;
  const bool gave_up = vtol_.gave_up();
  const std::optional<VtolState> reached = vtol_.update(context);
  if (vtol_.gave_up() && !gave_up) texts_.critical("Transition given up: too slow");
  if (!reached) return;
  texts_.info(*reached == VtolState::kPlane ? "Flying on the wing" : "Flying on the rotors");
  enter(mode_, context);
}

/// Thrust that does not lift the vehicle turns or drags it on its feet. A plane needs a run first.
void Commander::give_up_takeoff(const TaskContext& context) {
  constexpr double kClimbed_m = 0.3;
  constexpr double kPatience_s = 5;
  constexpr double kRun_s = 20;  // of a heavy plane on grass
  const bool automatic = mode_ == FlightMode::kTakeoff || mode_ == FlightMode::kMission;
  if (!flying_ || has_climbed_ || !automatic) return;
  has_climbed_ = context.ground_z - context.estimate.p_N.z() > kClimbed_m;
  climbing_s_ += context.dt;
  if (has_climbed_ || climbing_s_ < (on_wing() ? kRun_s : kPatience_s)) return;
  texts_.critical("Take-off given up: no climb");
  set_disarmed(": no climb");
}

void Commander::settle_on_ground(const TaskContext& context) {
  // Level, with less thrust at every step: on the ground nothing moves; in the air the vehicle
  // would sink, which ends the contact.
  constexpr double kThrustFall_per_s = 1.5;
  contact_thrust_ = std::max(0.0, contact_thrust_ - kThrustFall_per_s * context.dt);
  AttitudeSetpoint level;
  level.q_ND = base::quaternion_rpy(0, 0, context.yaw_rad);
  level.thrust_n = contact_thrust_ * context.params.hover_thrust * context.full_thrust_n;
  setpoint_ = ControlSetpoint{};
  setpoint_.attitude = level;
  setpoint_.near_ground = true;
}

void Commander::finish_tasks(const TaskContext& context) {
  if (on_wing()) {
    if (mode_ == FlightMode::kTakeoff && wing_.done(context)) enter(FlightMode::kHold, context);
    return;
  }
  if (mode_ == FlightMode::kTakeoff && flying_ && takeoff_.done(context)) {
    const Eigen::Vector3d target = takeoff_.target();
    enter(FlightMode::kHold, context);
    hold_.settle(target, takeoff_.yaw());
  }
  if (mode_ != FlightMode::kMission) return;
  if (const auto wanted = mission_.wanted_mode()) {
    enter(*wanted, context);
  } else if (mission_.finished()) {
    texts_.info("Mission finished");
    const Eigen::Vector3d target = mission_.target();
    const double yaw = mission_.yaw();
    enter(FlightMode::kHold, context);
    hold_.settle(target, yaw);
  }
}

void Commander::auto_disarm(const TaskContext& context) {
  if (flying_) return;
  landed_s_ += context.dt;
  const FlightParams& p = context.params;
  if (has_flown_ && p.disarm_after_landing_s >= 0 && landed_s_ > p.disarm_after_landing_s) {
    return set_disarmed(" after landing");
  }
  if (!has_flown_ && p.disarm_before_flight_s > 0 && armed_s_ > p.disarm_before_flight_s) {
    set_disarmed(": no take-off");
  }
}

ControlSetpoint Commander::update(const TaskContext& context, const FailsafeInput& failsafe,
                                  const ThrustRatio& thrust) {
  setpoint_ = ControlSetpoint{};
  if (armed_) {
    armed_s_ += context.dt;
    act(failsafe_.update(failsafe, context.params, mode_, flying_, context.dt), context);
  }
  if (armed_) update_flying(context, thrust);
  if (armed_) give_up_takeoff(context);
  if (armed_) auto_disarm(context);
  if (!armed_) {
    setpoint_.stopped = true;
    return setpoint_;
  }
  if (!flying_) {
    setpoint_.idle = true;
    return setpoint_;
  }
  update_transition(context);
  if (vtol_.under_way()) {
    setpoint_ = vtol_.setpoint(context);
    return setpoint_;
  }
  finish_tasks(context);
  setpoint_ = task(mode_).update(context);
  if (contact_ && !on_wing()) settle_on_ground(context);
  return setpoint_;
}

void Commander::on_position_reset(const Eigen::Vector3d& by_N) {
  if (mode_ != FlightMode::kOffboard) task(mode_).shift(by_N);
  vtol_.shift(by_N);
}

void Commander::on_sensors_lost(const std::string& what) {
  if (!armed_) return;
  texts_.add(StatusTexts::Severity::kEmergency, what + ": rotors stopped");
  if (flying_) mode_ = FlightMode::kTermination;
  set_disarmed("");
}

LandedState Commander::landed() const {
  if (!armed_ || !flying_) return LandedState::kOnGround;
  if (mode_ == FlightMode::kTakeoff) return LandedState::kTakingOff;
  if (mode_ == FlightMode::kLand) return LandedState::kLanding;
  return LandedState::kInAir;
}

}  // namespace cas::fcu
