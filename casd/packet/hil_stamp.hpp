// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// The stamp (microseconds) that, with the message id, is a HIL packet's identity in every ledger:
/// time_usec of HIL_SENSOR, HIL_GPS and the two controls; nothing for other packets.
inline std::optional<std::uint64_t> hil_time_usec(const mav::PacketView& packet) {
  using namespace mavlink::common;  // NOLINT: four of its messages
  switch (packet.message_id) {
    case HilSensor::kId:
    case HilGps::kId:
    case HilControls::kId:
    case HilActuatorControls::kId:
      break;
    default:
      return std::nullopt;
  }
  // It leads the payload of all four, little-endian; zeros at the end may be cut off.
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof value && i < packet.payload.size(); ++i) {
    value |= std::uint64_t{packet.payload[i]} << (8 * i);
  }
  return value;
}

}  // namespace cas::casd
