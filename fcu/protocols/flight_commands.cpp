// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/flight_commands.hpp"

#include <cmath>
#include <optional>

#include "base/angles.hpp"
#include "mavlink_gen/services/px4_modes.hpp"

namespace cas::fcu {

using base::RunTime;
using Eigen::Vector3d;
using mavlink::common::MavCmd;
using mavlink::common::MavFrame;
using mavlink::common::MavResult;

namespace {

constexpr double kForceMagic = 21196;  // MAV_CMD_COMPONENT_ARM_DISARM param2
constexpr std::uint32_t kMostFlags = 0xFFFF;
constexpr std::uint32_t kNoItem = 0xFFFF;  ///< no mission is that long

bool is_relative(MavFrame frame) {
  return frame == MavFrame::kGlobalRelativeAlt || frame == MavFrame::kGlobalRelativeAltInt;
}

/// The position of a command, in N; omitted components are NaN.
Vector3d place_of(const Command& command, const CommandTarget& target) {
  Vector3d p_N = unset3();
  const auto& projection = target.estimator.projection();
  if (!projection) return p_N;
  if (command.frame == MavFrame::kLocalNed) {
    return {command.param[4], command.param[5], command.param[6]};
  }
  const double alt = command.param[6];
  if (std::isfinite(command.param[4]) && std::isfinite(command.param[5])) {
    p_N.head<2>() =
        projection->to_local({command.param[4], command.param[5], projection->home().alt_m})
            .head<2>();
  }
  if (std::isfinite(alt)) {
    p_N.z() =
        is_relative(command.frame) ? target.home.p_N.z() - alt : projection->home().alt_m - alt;
  }
  return p_N;
}

MavResult arm_or_disarm(const Command& command, const CommandTarget& target, RunTime now) {
  const bool force = command.param[1] == kForceMagic;
  if (command.param[0] == 1) {
    const bool was_armed = target.commander.armed();
    const MavResult result =
        target.commander.arm(target.arming_input(now), target.context(now), force);
    if (result == MavResult::kAccepted && !was_armed) {
      target.home.set_here(target.estimator.state());
      target.reset_control();
    }
    return result;
  }
  if (command.param[0] == 0) return target.commander.disarm(force);
  return MavResult::kDenied;
}

bool is_known(MavFrame frame) {
  return frame == MavFrame::kGlobal || frame == MavFrame::kGlobalInt || is_relative(frame) ||
         frame == MavFrame::kLocalNed;
}

/// Whether the command's place is in its parameters 5 to 7.
bool names_a_place(MavCmd id) {
  return id == MavCmd::kNavTakeoff || id == MavCmd::kDoReposition || id == MavCmd::kDoSetHome;
}

MavResult take_off(const Command& command, const CommandTarget& target, RunTime now) {
  std::optional<double> z;
  const Vector3d place = place_of(command, target);
  if (std::isfinite(place.z())) z = place.z();
  const double yaw = command.param[3];  // degrees; senders leave 0 if unset
  const bool has_yaw = std::isfinite(yaw) && yaw != 0;
  return target.commander.take_off(z, has_yaw ? base::radians(yaw) : kUnset, target.context(now));
}

MavResult reposition(const Command& command, const CommandTarget& target, RunTime now) {
  const bool change_mode = (whole_number(command.param[1], kMostFlags) & 1) != 0;
  return target.commander.reposition(place_of(command, target), command.param[3], command.param[0],
                                     change_mode || target.commander.mode() == FlightMode::kHold,
                                     target.context(now));
}

MavResult orbit(const Command& command, const CommandTarget& target, RunTime now) {
  if (target.commander.on_wing()) {
    return target.commander.circle(place_of(command, target), command.param[0],
                                   target.context(now));
  }
  const double radius = std::isfinite(command.param[0]) ? std::abs(command.param[0]) : 0;
  const double speed = std::isfinite(command.param[1]) ? std::abs(command.param[1]) : 2;
  if (radius < 0.5 || speed <= 0) return MavResult::kDenied;
  if (speed * speed / radius > target.flight.acceleration_m_s2 * 1.5) return MavResult::kDenied;
  return target.commander.fly_pattern(PatternShape::kCircle, radius, speed, 0, target.context(now));
}

/// MAV_CMD_DO_VTOL_TRANSITION: parameter 1 is the MAV_VTOL_STATE that is asked for.
MavResult transition(const Command& command, const CommandTarget& target, RunTime now) {
  using mavlink::common::MavVtolState;
  const double asked = command.param[0];
  if (asked == static_cast<double>(MavVtolState::kFw)) {
    return target.commander.transition(true, target.context(now));
  }
  if (asked == static_cast<double>(MavVtolState::kMc)) {
    return target.commander.transition(false, target.context(now));
  }
  return MavResult::kDenied;
}

MavResult change_speed(const Command& command, const CommandTarget& target) {
  if (command.param[1] <= 0) return MavResult::kAccepted;  // -1: no change
  const char* const speed = target.commander.on_wing() ? "FW_AIRSPD_TRIM" : "MPC_XY_CRUISE";
  return target.params.set(speed, command.param[1]) == ParamSetResult::kOk ? MavResult::kAccepted
                                                                           : MavResult::kDenied;
}

MavResult set_home(const Command& command, const CommandTarget& target) {
  if (command.param[0] == 1) {
    if (!target.estimator.position_valid()) return MavResult::kTemporarilyRejected;
    const double ground = target.home.ground_z;
    target.home.set_here(target.estimator.state());
    if (target.commander.flying()) target.home.ground_z = ground;
    return MavResult::kAccepted;
  }
  const Vector3d place = place_of(command, target);
  if (!place.allFinite()) return MavResult::kDenied;
  target.home.p_N = place;
  target.home.set = true;
  return MavResult::kAccepted;
}

MavResult reboot(const Command& command, const CommandTarget& target) {
  if (command.param[0] != 1) return MavResult::kDenied;
  if (target.commander.armed()) return MavResult::kTemporarilyRejected;
  target.reboot_wanted = true;
  return MavResult::kAccepted;
}

}  // namespace

MavResult set_flight_mode(std::optional<FlightMode> mode, const CommandTarget& target,
                          RunTime now) {
  if (!mode) return MavResult::kUnsupported;
  const TaskContext context = target.context(now);
  if (*mode == FlightMode::kTakeoff)
    return target.commander.take_off(std::nullopt, kUnset, context);
  return target.commander.set_mode(*mode, context, Initiator::kCommand);
}

MavResult flight_command(const Command& command, const CommandTarget& target, RunTime now) {
  if (names_a_place(command.id) && !is_known(command.frame)) {
    return MavResult::kCommandUnsupportedMavFrame;
  }
  switch (command.id) {
    case MavCmd::kComponentArmDisarm:
      return arm_or_disarm(command, target, now);
    case MavCmd::kNavTakeoff:
      return take_off(command, target, now);
    case MavCmd::kNavLand:
      return set_flight_mode(FlightMode::kLand, target, now);
    case MavCmd::kNavReturnToLaunch:
      return set_flight_mode(FlightMode::kReturn, target, now);
    case MavCmd::kNavLoiterUnlim:
      return set_flight_mode(FlightMode::kHold, target, now);
    case MavCmd::kDoSetMode:
      return set_flight_mode(flight_mode_from_custom(mav::services::px4_number(
                                 static_cast<std::uint32_t>(whole_number(command.param[1], 255)),
                                 static_cast<std::uint32_t>(whole_number(command.param[2], 255)))),
                             target, now);
    case MavCmd::kDoReposition:
      return reposition(command, target, now);
    case MavCmd::kDoOrbit:
      return orbit(command, target, now);
    case MavCmd::kDoVtolTransition:
      return transition(command, target, now);
    case MavCmd::kDoChangeSpeed:
      return change_speed(command, target);
    case MavCmd::kDoSetHome:
      return set_home(command, target);
    case MavCmd::kDoPauseContinue:
      return set_flight_mode(command.param[0] == 0 ? FlightMode::kHold : FlightMode::kMission,
                             target, now);
    case MavCmd::kMissionStart: {
      const std::size_t first = whole_number(command.param[0], kNoItem);
      if (!target.commander.mission().set_current(first)) return MavResult::kDenied;
      return set_flight_mode(FlightMode::kMission, target, now);
    }
    case MavCmd::kDoFlighttermination:
      if (!(command.param[0] >= 0.5)) return MavResult::kDenied;  // NaN too
      target.commander.terminate("Flight terminated by command");
      return MavResult::kAccepted;
    case MavCmd::kPreflightRebootShutdown:
      return reboot(command, target);
    default:
      return MavResult::kUnsupported;
  }
}

}  // namespace cas::fcu
