// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mavlink/common/heartbeat.hpp"

namespace cas::mav::services {

/// HEARTBEAT of a system that is no autopilot: a ground station, a companion, a simulator.
inline mavlink::common::Heartbeat station_heartbeat(mavlink::common::MavType type) {
  mavlink::common::Heartbeat message;
  message.type = type;
  message.autopilot = mavlink::common::MavAutopilot::kInvalid;
  message.system_status = mavlink::common::MavState::kActive;
  message.mavlink_version = 3;
  return message;
}

}  // namespace cas::mav::services
