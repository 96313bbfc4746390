// SPDX-License-Identifier: BSD-3-Clause
#include "hils/hil_identity.hpp"

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

}  // namespace

std::optional<std::uint64_t> hil_time_usec(const mav::PacketView& packet) {
  switch (packet.message_id) {
    case mavlink::common::HilSensor::kId:
    case mavlink::common::HilGps::kId:
    case mavlink::common::HilControls::kId:
    case mavlink::common::HilActuatorControls::kId:
      return leading_u64(packet.payload);
    default:
      return std::nullopt;
  }
}

}  // namespace cas::hils
