// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/command.hpp"

#include <limits>

#include "mavlink_gen/services/vehicle_modes.hpp"
#include "mavlink_gen/services/vehicle_state.hpp"

namespace cas::mav::services {
namespace {

using mavlink::common::MavCmd;
using mavlink::common::MavModeFlag;
using mavlink::common::MavResult;

/// MAV_CMD_COMPONENT_ARM_DISARM param2: act against the vehicle's own checks.
constexpr float kForce = 21196;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

std::string describe(MavCmd id) {
  std::string text = "MAV_CMD " + std::to_string(static_cast<unsigned>(id));
  switch (id) {
    case MavCmd::kComponentArmDisarm:
      return text + " (arm or disarm)";
    case MavCmd::kNavTakeoff:
      return text + " (take off)";
    case MavCmd::kNavLand:
      return text + " (land)";
    case MavCmd::kNavReturnToLaunch:
      return text + " (return to launch)";
    case MavCmd::kDoSetMode:
      return text + " (set mode)";
    case MavCmd::kDoReposition:
      return text + " (reposition)";
    case MavCmd::kSetMessageInterval:
      return text + " (set message interval)";
    case MavCmd::kRequestMessage:
      return text + " (request message)";
    case MavCmd::kPreflightRebootShutdown:
      return text + " (reboot)";
    case MavCmd::kPreflightStorage:
      return text + " (store parameters)";
    default:
      return text;
  }
}

std::string describe(MavResult result) {
  switch (result) {
    case MavResult::kAccepted:
      return "accepted";
    case MavResult::kTemporarilyRejected:
      return "temporarily rejected";
    case MavResult::kDenied:
      return "denied";
    case MavResult::kUnsupported:
      return "not supported by the vehicle";
    case MavResult::kFailed:
      return "failed";
    case MavResult::kInProgress:
      return "in progress";
    case MavResult::kCancelled:
      return "cancelled";
    default:
      return "answered with result " + std::to_string(static_cast<unsigned>(result));
  }
}

VehicleCommand arm_command(bool arm, bool force) {
  VehicleCommand command{.id = MavCmd::kComponentArmDisarm};
  command.params[0] = arm ? 1.0F : 0.0F;
  command.params[1] = force ? kForce : 0.0F;
  return command;
}

VehicleCommand mode_command(const VehicleState& state, std::uint32_t mode) {
  constexpr MavModeFlag kKept = MavModeFlag::kSafetyArmed | MavModeFlag::kHilEnabled;
  MavModeFlag flags = MavModeFlag::kCustomModeEnabled;
  if (state.autopilot() == Autopilot::kPx4) flags |= state.heartbeat().message.base_mode & kKept;
  const ModeParams params = mode_params(state.autopilot(), mode);
  VehicleCommand command{.id = MavCmd::kDoSetMode};
  command.params = {static_cast<float>(flags), params.main, params.sub, 0, 0, 0, 0};
  return command;
}

VehicleCommand here_command(const VehicleState& state, MavCmd id) {
  VehicleCommand command{.id = id};
  if (state.autopilot() != Autopilot::kArduPilot) {
    command.params = {0, 0, 0, kNan, kNan, kNan, kNan};
  }
  return command;
}

VehicleCommand request_command(std::uint32_t message_id) {
  VehicleCommand command{.id = MavCmd::kRequestMessage};
  command.params[0] = static_cast<float>(message_id);
  return command;
}

VehicleCommand interval_command(std::uint32_t message_id, double period_us) {
  VehicleCommand command{.id = MavCmd::kSetMessageInterval};
  command.params[0] = static_cast<float>(message_id);
  command.params[1] = static_cast<float>(period_us);
  return command;
}

bool spins(const VehicleCommand& command) {
  switch (command.id) {
    case MavCmd::kComponentArmDisarm:
      return command.params[0] != 0;
    case MavCmd::kDoSetMode: {
      // A number that is no set of flags may be read as any of them.
      if (!(command.params[0] >= 0 && command.params[0] <= 255)) return true;
      const auto flags = static_cast<MavModeFlag>(static_cast<std::uint8_t>(command.params[0]));
      return has(flags, MavModeFlag::kSafetyArmed);
    }
    case MavCmd::kDoMotorTest:
    case MavCmd::kActuatorTest:
    case MavCmd::kMissionStart:  // PX4 arms for it
      return true;
    default:
      return false;
  }
}

bool stops(const VehicleCommand& command) {
  if (command.id == MavCmd::kComponentArmDisarm) return command.params[0] != 1;
  return command.id == MavCmd::kDoFlighttermination && command.params[0] != 0;
}

}  // namespace cas::mav::services
