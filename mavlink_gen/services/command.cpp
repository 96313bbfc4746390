// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/command.hpp"

#include <algorithm>
#include <array>
#include <cmath>
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

// Not in the dialect.
constexpr auto kDoEngineControl = static_cast<MavCmd>(223);
constexpr auto kDoAuxFunction = static_cast<MavCmd>(218);
constexpr auto kDoSetSafetySwitch = static_cast<MavCmd>(5300);

/// Commands that may start motors whatever their parameters; the dialect lacks most. Takeoffs (22,
/// 24, 84), DO_SET_PARAMETER, relays and servos (181 to 184), DO_SET_ACTUATOR, DO_MOTOR_TEST,
/// PREFLIGHT_UAVCAN, MISSION_START (PX4 arms for it), ACTUATOR_TEST, CONFIGURE_ACTUATOR, two clicks
/// of a Solo.
constexpr auto kSpinning = std::to_array<std::uint16_t>(
    {22, 24, 84, 180, 181, 182, 183, 184, 187, 209, 243, 300, 310, 311, 42001, 42002});

/// Functions of MAV_CMD_DO_AUX_FUNCTION.
constexpr int kMotorEmergencyStop = 31;
constexpr int kArmDisarm = 153;
constexpr int kArmDisarmAirMode = 154;
constexpr int kArmEmergencyStop = 165;

/// Whether an autopilot that cuts a parameter's decimals off reads it as this number.
bool is_read_as(float parameter, int number) {
  return std::trunc(parameter) == static_cast<float>(number);
}

/// A switch of a transmitter as a command: param1 its function, param2 low, middle or high.
bool aux_stops(const VehicleCommand& command) {
  constexpr int kLow = 0;
  constexpr int kHigh = 2;
  const auto is = [&command](int function) { return is_read_as(command.params[0], function); };
  if (is(kMotorEmergencyStop)) return is_read_as(command.params[1], kHigh);
  return (is(kArmDisarm) || is(kArmDisarmAirMode) || is(kArmEmergencyStop)) &&
         is_read_as(command.params[1], kLow);
}

/// Low releases an emergency stop; any other function it switches off.
bool aux_spins(const VehicleCommand& command) {
  const bool is_off =
      is_read_as(command.params[1], 0) && !is_read_as(command.params[0], kMotorEmergencyStop);
  return !is_off && !aux_stops(command);
}

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
    case MavCmd::kDoOrbit:
      return text + " (circle)";
    case MavCmd::kDoVtolTransition:
      return text + " (VTOL transition)";
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
  const auto number = static_cast<std::uint16_t>(command.id);
  if (std::ranges::find(kSpinning, number) != kSpinning.end()) return true;
  if (command.id == kDoAuxFunction) return aux_spins(command);
  if (command.id == kDoEngineControl || command.id == kDoSetSafetySwitch) {
    return command.params[0] != 0;
  }
  switch (command.id) {
    case MavCmd::kComponentArmDisarm:
      return command.params[0] != 0;
    case MavCmd::kDoSetMode: {
      // A number that is no set of flags may be read as any of them.
      if (!(command.params[0] >= 0 && command.params[0] <= 255)) return true;
      const auto flags = static_cast<MavModeFlag>(static_cast<std::uint8_t>(command.params[0]));
      return has(flags, MavModeFlag::kSafetyArmed);
    }
    case MavCmd::kDoFlighttermination:  // PX4 takes back a termination; it cuts off at a half
      return !(command.params[0] > 0.5F);
    case MavCmd::kPreflightCalibration:  // of compass against motors, of ESCs
      return is_read_as(command.params[5], 1) || is_read_as(command.params[6], 1);
    default:
      return false;
  }
}

bool stops(const VehicleCommand& command) {
  if (command.id == MavCmd::kComponentArmDisarm) return command.params[0] != 1;
  if (command.id == kDoAuxFunction) return aux_stops(command);
  return command.id == MavCmd::kDoFlighttermination && command.params[0] != 0;
}

}  // namespace cas::mav::services
