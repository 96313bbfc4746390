// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/failsafe.hpp"

#include <cmath>

namespace cas::fcu {
namespace {

using Decision = FailsafeDecision;
using Action = FailsafeDecision::Action;

Decision warn(std::string reason) {
  return {Action::kNone, FlightMode::kHold, std::move(reason), true};
}
Decision change(FlightMode mode, std::string reason) {
  return {Action::kMode, mode, std::move(reason), false};
}

/// NAV_DLL_ACT and NAV_RCL_ACT.
Decision loss_action(int action, const std::string& what) {
  switch (action) {
    case 1:
      return change(FlightMode::kHold, what + ": holding");
    case 2:
      return change(FlightMode::kReturn, what + ": returning");
    case 3:
      return change(FlightMode::kLand, what + ": landing");
    case 5:
      return {Action::kTerminate, FlightMode::kTermination, what + ": terminating", false};
    case 6:
      return {Action::kDisarm, FlightMode::kHold, what + ": disarming", false};
    default:
      return warn(what);
  }
}

/// COM_OBL_RC_ACT.
Decision offboard_action(int action, bool sticks) {
  const std::string what = "Offboard setpoints lost";
  switch (action) {
    case 0:
      return change(sticks ? FlightMode::kPosition : FlightMode::kHold, what);
    case 1:
      return change(sticks ? FlightMode::kAltitude : FlightMode::kHold, what);
    case 2:
      return change(sticks ? FlightMode::kStabilized : FlightMode::kHold, what);
    case 3:
      return change(FlightMode::kReturn, what + ": returning");
    case 4:
      return change(FlightMode::kLand, what + ": landing");
    case 6:
      return {Action::kTerminate, FlightMode::kTermination, what + ": terminating", false};
    case 7:
      return {Action::kDisarm, FlightMode::kHold, what + ": disarming", false};
    default:
      return change(FlightMode::kHold, what + ": holding");
  }
}

bool concerns(const Decision& decision) {
  return decision.action != Action::kNone || decision.warning_only;
}

}  // namespace

void Failsafe::reset() { *this = Failsafe{}; }

FailsafeDecision Failsafe::tilt(const FailsafeInput& in, const FlightParams& params, double dt) {
  const bool tilted = std::abs(in.roll_rad) > params.tilt_failure_roll_rad ||
                      std::abs(in.pitch_rad) > params.tilt_failure_pitch_rad;
  const double before = tilted_s_;
  tilted_s_ = tilted ? tilted_s_ + dt : 0;
  if (tilted_s_ < params.tilt_failure_time_s || before >= params.tilt_failure_time_s) return {};
  const std::string what = "Attitude failure: tilt too large";
  if (!params.termination_enabled) return warn(what);
  return {Action::kTerminate, FlightMode::kTermination, what + ", rotors stopped", false};
}

FailsafeDecision Failsafe::battery(const FailsafeInput& in, const FlightParams& params,
                                   FlightMode mode) {
  // PX4 warns, too, and does no more (failsafe.cpp: battery_unhealthy).
  if (first_time(!in.battery, battery_unknown_)) return warn("Battery unknown: no data");
  if (!in.battery) return {};
  int level = 0;
  if (*in.battery < params.battery_low) level = 1;
  if (*in.battery < params.battery_critical) level = 2;
  if (*in.battery < params.battery_emergency) level = 3;
  if (level <= battery_level_) return {};
  battery_level_ = level;
  if (level == 1 || params.battery_action == 0) {
    return warn(level == 1 ? "Low battery" : "Critical battery");
  }
  // COM_LOW_BAT_ACT: 2 lands at critical, 3 returns at critical and lands at emergency level.
  if (level == 3 || params.battery_action == 2) {
    return change(FlightMode::kLand, "Battery failsafe: landing");
  }
  if (mode == FlightMode::kLand) return warn("Critical battery");
  return change(FlightMode::kReturn, "Battery failsafe: returning");
}

FailsafeDecision Failsafe::position(const FailsafeInput& in, FlightMode mode, bool flying) {
  const bool lost = !in.position_valid && needs_position(mode);
  if (first_time(lost, position_lost_)) {
    return change(FlightMode::kLand, "Position lost: descending");
  }
  // One of the two was wrong all the time, and nothing tells which.
  const std::uint64_t before = position_resets_.value_or(in.position_resets);
  position_resets_ = in.position_resets;
  if (in.position_resets == before || !flying) return {};
  const std::string what = "GPS contradicted the estimate";
  return needs_position(mode) ? change(FlightMode::kLand, what + ": landing") : warn(what);
}

FailsafeDecision Failsafe::links(const FailsafeInput& in, const FlightParams& params,
                                 FlightMode mode) {
  const bool landing = mode == FlightMode::kLand || mode == FlightMode::kTermination;
  const bool offboard_lost = mode == FlightMode::kOffboard && !in.offboard_alive;
  if (first_time(offboard_lost, offboard_lost_)) {
    return offboard_action(params.offboard_loss_action, in.sticks_alive);
  }
  const bool sticks_lost = is_manual(mode) && !in.sticks_alive;
  if (first_time(sticks_lost, sticks_lost_)) {
    // Without a pilot a manual mode cannot go on, whatever the parameter says.
    Decision decision = loss_action(params.manual_loss_action, "Manual control lost");
    if (decision.warning_only) decision = change(FlightMode::kHold, "Manual control lost: holding");
    return decision;
  }
  const bool station_lost = in.ground_station_seen && !in.ground_station_alive;
  if (first_time(station_lost, ground_station_lost_) && !landing) {
    return loss_action(params.ground_station_loss_action, "Ground station lost");
  }
  return {};
}

FailsafeDecision Failsafe::sensors(const FailsafeInput& in) {
  if (first_time(in.gps_frozen, gps_frozen_)) return warn("GPS repeats its last fix: not used");
  if (first_time(in.gps_contradicts_itself, gps_contradicts_itself_)) {
    return warn("GPS velocity contradicts position: not used");
  }
  if (first_time(!in.mag_alive, mag_lost_)) return warn("Compass lost: heading by gyro");
  if (first_time(!in.baro_alive, baro_lost_)) return warn("Barometer lost: height by GPS");
  return {};
}

FailsafeDecision Failsafe::update(const FailsafeInput& in, const FlightParams& params,
                                  FlightMode mode, bool flying, double dt) {
  if (!flying) {
    // On the ground only the companion's silence and the battery change anything.
    tilted_s_ = 0;
  }
  if (Decision decision = flying ? tilt(in, params, dt) : Decision{}; concerns(decision)) {
    active_ = true;
    return decision;
  }
  if (Decision decision = position(in, mode, flying); concerns(decision)) {
    active_ = active_ || !decision.warning_only;
    return decision;
  }
  if (Decision decision = battery(in, params, mode); concerns(decision)) {
    active_ = active_ || !decision.warning_only;
    return decision;
  }
  if (Decision decision = links(in, params, mode); concerns(decision)) {
    active_ = active_ || !decision.warning_only;
    return decision;
  }
  return sensors(in);
}

}  // namespace cas::fcu
