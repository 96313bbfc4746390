// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/motion.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <span>
#include <string>

#include "mavlink/common/command_int.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/param_set.hpp"
#include "mavlink/common/set_mode.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "mavlink_gen/services/px4_modes.hpp"

namespace cas::mav::services {
namespace {

using namespace mavlink::common;  // NOLINT: four of its messages and its enumerations

template <std::size_t n, class Number>
bool holds(const std::array<Number, n>& numbers, std::uint32_t number) {
  return std::ranges::find(numbers, number) != numbers.end();
}

// Commands by number: the dialect has few of common.xml's, and none of ardupilotmega.xml's.

/// Questions, streams, cameras, lights, logs, calibration of the compass.
constexpr auto kQuietCommands = std::to_array<std::uint16_t>(
    {200,  202,  203,  206,  214,  401,  405,  406,  410,  420,  510,   511,   512,   519,  520,
     521,  522,  525,  526,  527,  528,  529,  530,  531,  532,  533,   534,   2000,  2001, 2003,
     2500, 2501, 2502, 2503, 2504, 2505, 2510, 2511, 2600, 3001, 42424, 42425, 42426, 42429});

/// Loiter where it is, return, land, land here, vertical landing, the mission's landing, pause of a
/// Solo.
constexpr auto kStopCommands = std::to_array<std::uint16_t>({17, 20, 21, 23, 85, 189, 42003});

bool is_command(const VehicleCommand& command, unsigned number) {
  return static_cast<unsigned>(command.id) == number;
}

/// Whether a parameter is exactly this number.
bool is(float parameter, int number) { return parameter == static_cast<float>(number); }

bool loads_or_stores(float parameter) { return is(parameter, 0) || is(parameter, 1); }

/// Whether a command stops the motors at once.
bool cuts(const VehicleCommand& command) {
  constexpr unsigned kSetSafetySwitch = 5300;
  if (is_command(command, kSetSafetySwitch)) return is(command.params[0], 0);
  return stops(command);
}

/// Commands that stop the vehicle with some parameters and move it with others.
bool stays(const VehicleCommand& command) {
  constexpr unsigned kPauseContinue = 193;
  constexpr unsigned kOverrideGoto = 252;
  constexpr unsigned kSetStandardMode = 262;
  const auto& params = command.params;
  if (is_command(command, kPauseContinue)) return is(params[0], 0);
  // MAV_GOTO_DO_HOLD, MAV_GOTO_HOLD_AT_CURRENT_POSITION
  if (is_command(command, kOverrideGoto)) return is(params[0], 0) && is(params[1], 2);
  // MAV_STANDARD_MODE_SAFE_RECOVERY, MAV_STANDARD_MODE_LAND
  if (is_command(command, kSetStandardMode)) return is(params[0], 5) || is(params[0], 7);
  return holds(kStopCommands, static_cast<unsigned>(command.id));
}

/// Whether a mode keeps an ArduPilot in place or brings it home: LOITER, RTL, LAND, BRAKE, HOLD.
bool is_still_ardupilot(MavType type, std::uint32_t mode) {
  constexpr auto kCopter = std::to_array<std::uint32_t>({5, 6, 9, 17, 21});
  constexpr auto kPlane = std::to_array<std::uint32_t>({11, 12, 19, 20, 21});
  constexpr auto kRover = std::to_array<std::uint32_t>({4, 11, 12});
  switch (mode_set(Autopilot::kArduPilot, type)) {
    case ModeSet::kCopter:
      return holds(kCopter, mode);
    case ModeSet::kPlane:
      return holds(kPlane, mode);
    case ModeSet::kRover:
      return holds(kRover, mode);
    default:
      return false;
  }
}

bool is_still_px4(std::uint32_t mode) {
  constexpr std::array kStill{px4_mode("HOLD").number, px4_mode("RTL").number,
                              px4_mode("LAND").number, px4_mode("PRECLAND").number};
  return holds(kStill, mode);
}

/// @param flags  with the armed flag a disarmed vehicle may arm
Motion motion_of_mode(MavModeFlag flags, std::uint32_t mode, const Addressee& to) {
  const bool custom = has(flags, MavModeFlag::kCustomModeEnabled);
  const bool still =
      custom && (to.autopilot == Autopilot::kPx4
                     ? is_still_px4(mode)
                     : to.autopilot == Autopilot::kArduPilot && is_still_ardupilot(to.type, mode));
  const bool known = to.autopilot != Autopilot::kOther;
  const bool arms = has(flags, MavModeFlag::kSafetyArmed) && !(known && to.armed);
  if (arms) return Motion::kSpins;
  if (custom && to.autopilot == Autopilot::kPx4 && mode == px4_mode("TERMINATION").number) {
    return Motion::kCuts;
  }
  return still ? Motion::kStops : Motion::kMoves;
}

bool is_byte(float number) { return number >= 0 && number <= 255; }

Motion motion_of_set_mode(const VehicleCommand& command, const Addressee& to) {
  const auto& [base, main, sub, a, b, c, d] = command.params;
  // A number that is no set of flags may be read as any of them.
  if (!is_byte(base)) return Motion::kSpins;
  const auto flags = static_cast<MavModeFlag>(static_cast<std::uint8_t>(base));
  const bool readable = is_byte(main) && is_byte(sub);
  const auto main_number = readable ? static_cast<std::uint32_t>(main) : 0U;
  const std::uint32_t mode =
      to.autopilot == Autopilot::kPx4
          ? px4_number(main_number, static_cast<std::uint32_t>(readable ? sub : 0.0F))
          : main_number;
  const Motion motion = motion_of_mode(flags, mode, to);
  return readable ? motion : std::max(motion, Motion::kMoves);
}

template <class Command>
VehicleCommand read(const Command& message) {
  VehicleCommand command{.id = message.command};
  command.params = {message.param1, message.param2, message.param3, message.param4};
  if constexpr (requires { message.param5; }) {
    command.params[4] = message.param5;
    command.params[5] = message.param6;
    command.params[6] = message.param7;
  } else {
    command.params[4] = static_cast<float>(message.x);
    command.params[5] = static_cast<float>(message.y);
    command.params[6] = message.z;
  }
  return command;
}

// Messages by number, for the same reason.

/// MANUAL_CONTROL, RC_CHANNELS_OVERRIDE and its second version, RADIO_RC_CHANNELS,
/// CUBEPILOT_RAW_RC, MANUAL_SETPOINT (gestures of sticks arm); SET_ACTUATOR_CONTROL_TARGET;
/// SERIAL_CONTROL (a console); commands with a time of ASLUAV, which nothing here reads;
/// SECURE_COMMAND; DEVICE_OP_WRITE, CAN_FRAME, CANFD_FRAME (the bus of the motors' controllers),
/// ESC_EEPROM.
constexpr auto kSpinningMessages = std::to_array<std::uint32_t>(
    {69, 70, 81, 126, 139, 223, 224, 292, 386, 387, 420, 421, 11002, 11004, 50001});

/// RC_CHANNELS are a vehicle's report, but sticks for PX4 when they come from this component,
/// MAV_COMP_ID_SYSTEM_CONTROL.
constexpr std::uint32_t kRcChannels = 65;
constexpr std::uint8_t kSystemControl = 250;

/// Parts of a mission and its current item; fence, rally points, home, origin; SET_ATTITUDE_TARGET,
/// both SET_POSITION_TARGETs, trajectories, SET_VELOCITY_LIMITS; PARAM_MAP_RC, SET_MAG_OFFSETS;
/// TUNNEL, V2_EXTENSION; SETUP_SIGNING (no station could stop it any more); an update of firmware.
constexpr auto kMovingMessages =
    std::to_array<std::uint32_t>({38,  39,  41,  44,  45,  48,  50,  54,  73,  82,  84,   86,
                                  151, 160, 175, 243, 248, 256, 332, 333, 354, 385, 50004});

/// Positions of others (GLOBAL_POSITION_INT, FOLLOW_TARGET, ADSB_VEHICLE, COLLISION, AIS_VESSEL,
/// UTM_GLOBAL_POSITION, TARGET_*), which a vehicle may follow or avoid; sensors, batteries and
/// positions measured elsewhere; the HIL streams.
constexpr auto kMisleadingMessages = std::to_array<std::uint32_t>(
    {33,  90,  91,  92,  93,  100, 101, 102, 103, 104,   106,  107, 113,
     114, 115, 123, 132, 134, 138, 144, 147, 149, 232,   233,  246, 247,
     295, 296, 301, 330, 331, 340, 510, 511, 513, 11011, 11037});

constexpr std::uint32_t kFileTransfer = 110;
constexpr std::uint32_t kParamExtSet = 323;

/// Whether an operation of MAVLink's file transfer changes nothing: lists and reads, answers.
bool only_reads(std::span<const std::uint8_t> payload) {
  constexpr std::size_t kOpcodeAt = 6;  // after three addresses, number and session
  constexpr std::uint8_t kFirstAnswer = 128;
  constexpr auto kReads = std::to_array<std::uint32_t>({0, 1, 2, 3, 4, 5, 14, 15});
  const std::uint8_t opcode = payload.size() > kOpcodeAt ? payload[kOpcodeAt] : 0;
  return opcode >= kFirstAnswer || holds(kReads, opcode);
}

/// The name in a PARAM_EXT_SET.
std::string ext_name(std::span<const std::uint8_t> payload) {
  constexpr std::size_t kNameAt = 2;
  constexpr std::size_t kNameLength = 16;
  std::string name;
  for (std::size_t i = kNameAt; i < std::min(payload.size(), kNameAt + kNameLength); ++i) {
    if (payload[i] == 0) break;
    name += static_cast<char>(payload[i]);
  }
  return name;
}

}  // namespace

Addressee addressee_of(const Heartbeat& heartbeat) {
  return {.autopilot = autopilot_family(heartbeat.autopilot),
          .type = heartbeat.type,
          .armed = has(heartbeat.base_mode, MavModeFlag::kSafetyArmed)};
}

Motion motion_of(const VehicleCommand& command, const Addressee& to) {
  if (command.id == MavCmd::kDoSetMode) return motion_of_set_mode(command, to);
  if (spins(command)) return Motion::kSpins;
  if (cuts(command)) return Motion::kCuts;
  if (stays(command)) return Motion::kStops;
  if (holds(kQuietCommands, static_cast<unsigned>(command.id))) return Motion::kNone;
  switch (command.id) {
    case MavCmd::kPreflightCalibration:  // the last two: with motors, of ESCs, of airspeed
      return is(command.params[5], 0) && is(command.params[6], 0) ? Motion::kNone : Motion::kMoves;
    case MavCmd::kPreflightStorage:  // others than load and store reset to defaults
      return loads_or_stores(command.params[0]) && loads_or_stores(command.params[1])
                 ? Motion::kNone
                 : Motion::kMoves;
    case MavCmd::kPreflightRebootShutdown:  // in flight the vehicle falls
      return to.armed && !is(command.params[0], 0) ? Motion::kMoves : Motion::kNone;
    default:
      return Motion::kMoves;
  }
}

Motion motion_of_parameter(std::string_view name) {
  constexpr auto kArming = std::to_array<std::string_view>(
      {"ARMING_",        "AUTO_OPTIONS", "BRD_SAFETY", "BTN_",          "CA_",
       "CAN_",           "CBRK_",        "COM_ARM",    "COM_MOT_TEST",  "COM_PREARM",
       "COM_RC_IN_MODE", "DSHOT_",       "ESC_CAL",    "FRAME_",        "GUID_OPTIONS",
       "HIL_ACT_",       "H_RSC_",       "ICE_",       "MAN_ARM_",      "MOT_",
       "PCA9685_",       "PWM_",         "Q_M_",       "RC_MAP_",       "RC_OPTIONS",
       "RELAY",          "SCR_ENABLE",   "SERVO",      "SYS_AUTOSTART", "SYS_HAS_",
       "SYS_HITL",       "TAP_ESC_",     "UAVCAN_",    "VOXL_ESC_"});
  std::string upper(name);  // ArduPilot takes either case
  std::ranges::transform(upper, upper.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  const bool arms = std::ranges::any_of(
      kArming, [&upper](std::string_view prefix) { return upper.starts_with(prefix); });
  // A switch of a transmitter: RC7_OPTION, CH7_OPT.
  const bool switches = (upper.starts_with("RC") && upper.ends_with("_OPTION")) ||
                        (upper.starts_with("CH") && upper.ends_with("_OPT"));
  return arms || switches ? Motion::kSpins : Motion::kMoves;
}

bool leads_into_hil(std::string_view parameter, double value) {
  if (parameter == "SYS_AUTOSTART") return value >= 1000 && value < 2000;
  return parameter == "SYS_HITL" || parameter.starts_with("HIL_ACT_");
}

Motion motion_of(const PacketView& packet, const Addressee& to) {
  if (const auto command = decode<CommandLong>(packet)) return motion_of(read(*command), to);
  if (const auto placed = decode<CommandInt>(packet)) return motion_of(read(*placed), to);
  if (const auto mode = decode<SetMode>(packet)) {
    return motion_of_mode(mode->base_mode, mode->custom_mode, to);
  }
  if (const auto set = decode<ParamSet>(packet)) return motion_of_parameter(text(set->param_id));
  const std::uint32_t id = packet.message_id;
  if (id == kParamExtSet) return motion_of_parameter(ext_name(packet.payload));
  if (id == kFileTransfer) return only_reads(packet.payload) ? Motion::kNone : Motion::kMoves;
  const bool sticks = id == kRcChannels && packet.source.component == kSystemControl;
  if (sticks || holds(kSpinningMessages, id)) return Motion::kSpins;
  if (holds(kMovingMessages, id)) return Motion::kMoves;
  const bool is_public = public_table().find(id) != nullptr;
  return !is_public || holds(kMisleadingMessages, id) ? Motion::kMisleads : Motion::kNone;
}

}  // namespace cas::mav::services
