// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mavlink/common/enums.hpp"

namespace cas::mav::services {

/// Whose conventions a vehicle follows: mode numbers, takeoff altitude, parameter bytes, names of
/// gains.
enum class Autopilot { kPx4, kArduPilot, kOther };

Autopilot autopilot_family(mavlink::common::MavAutopilot wire);
/// "PX4", "ArduPilot", "other".
std::string_view name(Autopilot autopilot);

/// Whose numbers HEARTBEAT.custom_mode has: PX4's are the same on every vehicle, ArduPilot's are
/// not (4 is GUIDED of a copter, ACRO of a plane and HOLD of a rover).
enum class ModeSet { kNone, kPx4, kCopter, kPlane, kRover, kSub };

/// @param type  HEARTBEAT.type; a type of ArduPilot that has no set here gives kNone
ModeSet mode_set(Autopilot autopilot, mavlink::common::MavType type);

/// Word for HEARTBEAT.custom_mode: "TAKEOFF", "HOLD", "LAND", "POSCTL", "GUIDED", ...; a mode this
/// table does not know reads "custom 0x..."; without the custom flag "base 0x..".
std::string mode_name(ModeSet set, mavlink::common::MavModeFlag base_mode,
                      std::uint32_t custom_mode);

/// HEARTBEAT.custom_mode of a mode's word (any case; PX4 also LOITER for HOLD).
std::optional<std::uint32_t> custom_mode(ModeSet set, std::string_view word);

/// The words that custom_mode() takes.
std::vector<std::string_view> mode_words(ModeSet set);

/// Parameters 2 and 3 of MAV_CMD_DO_SET_MODE for a custom mode.
struct ModeParams {
  float main = 0;
  float sub = 0;
};
ModeParams mode_params(Autopilot autopilot, std::uint32_t custom_mode);

}  // namespace cas::mav::services
