// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/command_handler.hpp"

#include <cmath>
#include <limits>
#include <optional>

#include "fcu/fcu_core.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/message_interval.hpp"
#include "mavlink/common/protocol_version.hpp"

namespace cas::fcu {

using base::RunTime;
using Eigen::Vector3d;
using mavlink::common::CommandAck;
using mavlink::common::CommandInt;
using mavlink::common::CommandLong;
using mavlink::common::MavCmd;
using mavlink::common::MavFrame;
using mavlink::common::MavModeFlag;
using mavlink::common::MavResult;
using mavlink::common::SetMode;

namespace {

constexpr double kForceMagic = 21196;  // MAV_CMD_COMPONENT_ARM_DISARM param2

TaskContext context_of(const FcuCore& core, RunTime now) { return core.context(now, 0); }

bool is_relative(MavFrame frame) {
  return frame == MavFrame::kGlobalRelativeAlt || frame == MavFrame::kGlobalRelativeAltInt;
}

/// The place a command names, in N; what it leaves out is NaN.
Vector3d place_of(const Command& command, const FcuCore& core) {
  Vector3d p_N = unset3();
  const auto& projection = core.estimator.projection();
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
    p_N.z() = is_relative(command.frame) ? core.home_N.z() - alt : projection->home().alt_m - alt;
  }
  return p_N;
}

MavResult arm_or_disarm(const Command& command, FcuCore& core, RunTime now) {
  const bool force = command.param[1] == kForceMagic;
  if (command.param[0] == 1) {
    const bool was_armed = core.commander.armed();
    const MavResult result =
        core.commander.arm(core.arming_input(now), context_of(core, now), force);
    if (result == MavResult::kAccepted && !was_armed) {
      core.set_home_here();
      core.cascade.reset();
    }
    return result;
  }
  if (command.param[0] == 0) return core.commander.disarm(force);
  return MavResult::kDenied;
}

MavResult set_flight_mode(std::optional<FlightMode> mode, FcuCore& core, RunTime now) {
  if (!mode) return MavResult::kUnsupported;
  const TaskContext context = context_of(core, now);
  if (*mode == FlightMode::kTakeoff) return core.commander.take_off(std::nullopt, kUnset, context);
  return core.commander.set_mode(*mode, context, Initiator::kCommand);
}

MavResult take_off(const Command& command, FcuCore& core, RunTime now) {
  std::optional<double> z;
  const Vector3d place = place_of(command, core);
  if (std::isfinite(place.z())) z = place.z();
  const double yaw = command.param[3];  // degrees; 0 is what senders leave in it
  const bool has_yaw = std::isfinite(yaw) && yaw != 0;
  return core.commander.take_off(z, has_yaw ? yaw * M_PI / 180 : kUnset, context_of(core, now));
}

MavResult reposition(const Command& command, FcuCore& core, RunTime now) {
  const bool change_mode = (static_cast<int>(command.param[1]) & 1) != 0;
  return core.commander.reposition(place_of(command, core), command.param[3], command.param[0],
                                   change_mode || core.commander.mode() == FlightMode::kHold,
                                   context_of(core, now));
}

MavResult orbit(const Command& command, FcuCore& core, RunTime now) {
  const double radius = std::isfinite(command.param[0]) ? std::abs(command.param[0]) : 0;
  const double speed = std::isfinite(command.param[1]) ? std::abs(command.param[1]) : 2;
  if (radius < 0.5 || speed <= 0) return MavResult::kDenied;
  if (speed * speed / radius > core.flight.acceleration_m_s2 * 1.5) return MavResult::kDenied;
  return core.commander.fly_pattern(PatternShape::kCircle, radius, speed, 0, context_of(core, now));
}

MavResult change_speed(const Command& command, FcuCore& core) {
  if (command.param[1] <= 0) return MavResult::kAccepted;  // -1: no change
  return core.params.set("MPC_XY_CRUISE", command.param[1]) == ParamSetResult::kOk
             ? MavResult::kAccepted
             : MavResult::kDenied;
}

MavResult set_home(const Command& command, FcuCore& core) {
  if (command.param[0] == 1) {
    if (!core.estimator.position_valid()) return MavResult::kTemporarilyRejected;
    const double ground = core.ground_z;
    core.set_home_here();
    if (core.commander.flying()) core.ground_z = ground;
    return MavResult::kAccepted;
  }
  const Vector3d place = place_of(command, core);
  if (!place.allFinite()) return MavResult::kDenied;
  core.home_N = place;
  core.home_set = true;
  return MavResult::kAccepted;
}

MavResult reboot(const Command& command, FcuCore& core) {
  if (command.param[0] != 1) return MavResult::kDenied;
  if (core.commander.armed()) return MavResult::kTemporarilyRejected;
  core.reboot_wanted = true;
  return MavResult::kAccepted;
}

}  // namespace

void CommandHandler::acknowledge(const Command& command, Result result, FcuCore& core) const {
  CommandAck ack;
  ack.command = command.id;
  ack.result = result;
  ack.target_system = command.from.system;
  ack.target_component = command.from.component;
  core.outbox.reply(ack, command.version);
}

void CommandHandler::on_long(const CommandLong& m, mav::Source from, int version, FcuCore& core,
                             RunTime now) {
  Command command;
  command.id = m.command;
  const float values[] = {m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7};
  for (std::size_t i = 0; i < 7; ++i) command.param[i] = static_cast<double>(values[i]);
  // A whole planet in a float is good to a metre; 0, 0 is what senders leave in it.
  if (command.param[4] == 0 && command.param[5] == 0) command.param[4] = command.param[5] = kUnset;
  command.from = from;
  command.version = version;
  acknowledge(command, execute(command, core, now), core);
}

void CommandHandler::on_int(const CommandInt& m, mav::Source from, int version, FcuCore& core,
                            RunTime now) {
  constexpr std::int32_t kNoPlace = std::numeric_limits<std::int32_t>::max();
  Command command;
  command.id = m.command;
  const float values[] = {m.param1, m.param2, m.param3, m.param4};
  for (std::size_t i = 0; i < 4; ++i) command.param[i] = static_cast<double>(values[i]);
  const double unit = m.frame == MavFrame::kLocalNed ? 1e-4 : 1e-7;
  command.param[4] = m.x == kNoPlace ? kUnset : m.x * unit;
  command.param[5] = m.y == kNoPlace ? kUnset : m.y * unit;
  if (m.x == 0 && m.y == 0 && m.frame != MavFrame::kLocalNed) {
    command.param[4] = command.param[5] = kUnset;
  }
  command.param[6] = static_cast<double>(m.z);
  command.frame = m.frame;
  command.from = from;
  command.version = version;
  acknowledge(command, execute(command, core, now), core);
}

void CommandHandler::on_set_mode(const SetMode& m, mav::Source from, int version, FcuCore& core,
                                 RunTime now) {
  Command command;
  command.id = MavCmd::kDoSetMode;
  command.from = from;
  command.version = version;
  const MavResult result =
      has(static_cast<MavModeFlag>(m.base_mode), MavModeFlag::kCustomModeEnabled)
          ? set_flight_mode(flight_mode_from_custom(m.custom_mode), core, now)
          : MavResult::kUnsupported;
  acknowledge(command, result, core);
}

MavResult CommandHandler::execute(const Command& command, FcuCore& core, RunTime now) {
  const MavResult result = flight_command(command, core, now);
  if (result != MavResult::kUnsupported) {
    telemetry_.hurry();
    return result;
  }
  return information_command(command, core, now);
}

MavResult CommandHandler::flight_command(const Command& command, FcuCore& core, RunTime now) {
  switch (command.id) {
    case MavCmd::kComponentArmDisarm:
      return arm_or_disarm(command, core, now);
    case MavCmd::kNavTakeoff:
      return take_off(command, core, now);
    case MavCmd::kNavLand:
      return set_flight_mode(FlightMode::kLand, core, now);
    case MavCmd::kNavReturnToLaunch:
      return set_flight_mode(FlightMode::kReturn, core, now);
    case MavCmd::kNavLoiterUnlim:
      return set_flight_mode(FlightMode::kHold, core, now);
    case MavCmd::kDoSetMode:
      return set_flight_mode(flight_mode_from_px4(static_cast<std::uint8_t>(command.param[1]),
                                                  static_cast<std::uint8_t>(command.param[2])),
                             core, now);
    case MavCmd::kDoReposition:
      return reposition(command, core, now);
    case MavCmd::kDoOrbit:
      return orbit(command, core, now);
    case MavCmd::kDoChangeSpeed:
      return change_speed(command, core);
    case MavCmd::kDoSetHome:
      return set_home(command, core);
    case MavCmd::kDoPauseContinue:
      return set_flight_mode(command.param[0] == 0 ? FlightMode::kHold : FlightMode::kMission, core,
                             now);
    case MavCmd::kMissionStart: {
      const auto first = static_cast<std::size_t>(std::max(0.0, command.param[0]));
      if (!core.commander.mission().set_current(first)) return MavResult::kDenied;
      return set_flight_mode(FlightMode::kMission, core, now);
    }
    case MavCmd::kDoFlighttermination:
      if (command.param[0] < 0.5) return MavResult::kDenied;
      core.commander.terminate("Flight terminated by command");
      return MavResult::kAccepted;
    case MavCmd::kPreflightRebootShutdown:
      return reboot(command, core);
    default:
      return MavResult::kUnsupported;
  }
}

MavResult CommandHandler::information_command(const Command& command, FcuCore& core, RunTime now) {
  const auto id = static_cast<std::uint32_t>(std::max(0.0, command.param[0]));
  switch (command.id) {
    case MavCmd::kRequestMessage:
      return telemetry_.send_now(id, core, now, command.version) ? MavResult::kAccepted
                                                                 : MavResult::kUnsupported;
    case MavCmd::kSetMessageInterval:
      return telemetry_.set_interval(id, command.param[1]) ? MavResult::kAccepted
                                                           : MavResult::kUnsupported;
    case MavCmd::kGetMessageInterval:
      core.outbox.reply(mavlink::common::MessageInterval{static_cast<std::uint16_t>(id),
                                                         telemetry_.interval_us(id)},
                        command.version);
      return MavResult::kAccepted;
    case MavCmd::kRequestAutopilotCapabilities:
      telemetry_.send_now(mavlink::common::AutopilotVersion::kId, core, now, command.version);
      return MavResult::kAccepted;
    case MavCmd::kRequestProtocolVersion:
      telemetry_.send_now(mavlink::common::ProtocolVersion::kId, core, now, 2);
      return MavResult::kAccepted;
    case MavCmd::kGetHomePosition:
      telemetry_.send_now(mavlink::common::HomePosition::kId, core, now, command.version);
      return core.home_set ? MavResult::kAccepted : MavResult::kTemporarilyRejected;
    case MavCmd::kRunPrearmChecks:
      if (const auto reason = reason_not_to_arm(core.arming_input(now))) {
        core.texts.critical("Preflight Fail: " + *reason);
      } else {
        core.texts.info("Preflight checks passed");
      }
      return MavResult::kAccepted;
    case MavCmd::kPreflightStorage:
      // Parameters are saved as they change; 2 resets them.
      if (command.param[0] == 2) core.params.reset_to_defaults();
      return MavResult::kAccepted;
    default:
      return MavResult::kUnsupported;
  }
}

}  // namespace cas::fcu
