// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/high_latency2.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::mav::services {

/// MAV_COMP_ID_AUTOPILOT1.
inline constexpr std::uint8_t kAutopilot = 1;

/// Whether a HEARTBEAT is a flight controller's: simulators, cameras and companions say
/// MAV_AUTOPILOT_INVALID, some MAV_AUTOPILOT_GENERIC, ground stations their type.
inline bool is_vehicle(Source source, const mavlink::common::Heartbeat& heartbeat) {
  using namespace mavlink::common;
  if (heartbeat.autopilot == MavAutopilot::kInvalid || heartbeat.type == MavType::kGcs) {
    return false;
  }
  return heartbeat.autopilot != MavAutopilot::kGeneric || source.component == kAutopilot;
}

/// The HEARTBEAT made from a HIGH_LATENCY2. It has two bytes of the mode, of PX4 the upper ones.
/// ArduPilot has its base mode in `custom0`; for others the last armed state stays. The HIL flag is
/// never set: arming needs it in a HEARTBEAT.
/// @param last  the previous HEARTBEAT
inline mavlink::common::Heartbeat heartbeat_of(const mavlink::common::HighLatency2& message,
                                               const mavlink::common::Heartbeat& last) {
  using namespace mavlink::common;
  constexpr unsigned kUpperHalf = 16;
  Heartbeat heartbeat = last;
  heartbeat.type = message.type;
  heartbeat.autopilot = message.autopilot;
  heartbeat.custom_mode = message.autopilot == MavAutopilot::kPx4
                              ? std::uint32_t{message.custom_mode} << kUpperHalf
                              : message.custom_mode;
  const auto flags = message.autopilot == MavAutopilot::kArdupilotmega
                         ? static_cast<MavModeFlag>(static_cast<std::uint8_t>(message.custom0))
                         : last.base_mode & MavModeFlag::kSafetyArmed;
  heartbeat.base_mode = (flags | MavModeFlag::kCustomModeEnabled) & ~MavModeFlag::kHilEnabled;
  return heartbeat;
}

}  // namespace cas::mav::services
