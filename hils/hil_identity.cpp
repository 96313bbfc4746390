// SPDX-License-Identifier: BSD-3-Clause
#include "hils/hil_identity.hpp"

#include <span>

#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::hils {

namespace {

/// time_usec leads the payload of all four messages, little-endian; zeros at the end may be cut.
std::uint64_t leading_u64(std::span<const std::uint8_t> payload) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(value) && i < payload.size(); ++i) {
    value |= static_cast<std::uint64_t>(payload[i]) << (8 * i);
  }
  return value;
}

bool is_hil(std::uint32_t message_id) {
  return message_id == mavlink::common::HilSensor::kId ||
         message_id == mavlink::common::HilGps::kId ||
         message_id == mavlink::common::HilControls::kId ||
         message_id == mavlink::common::HilActuatorControls::kId;
}

}  // namespace

std::optional<std::uint64_t> hil_time_usec(const mav::PacketView& packet) {
  if (!is_hil(packet.message_id)) return std::nullopt;
  return leading_u64(packet.payload);
}

}  // namespace cas::hils
