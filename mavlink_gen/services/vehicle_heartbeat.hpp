// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "mavlink/common/heartbeat.hpp"
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

}  // namespace cas::mav::services
