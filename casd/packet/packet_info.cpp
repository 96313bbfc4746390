// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet/packet_info.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/enum_words.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink_gen/runtime/message.hpp"

namespace cas::casd {
namespace {

using ClassTable = std::array<TrafficClass, kTabledIds>;

constexpr void mark(ClassTable& table, std::uint32_t first, std::uint32_t last,
                    TrafficClass traffic) {
  for (std::uint32_t id = first; id <= last; ++id) table[id] = traffic;
}

constexpr ClassTable make_class_table() {
  ClassTable table{};
  for (TrafficClass& entry : table) entry = TrafficClass::kTelemetry;
  constexpr auto kCommand = TrafficClass::kCommand;
  mark(table, 0, 0, kCommand);      // HEARTBEAT
  mark(table, 2, 2, kCommand);      // SYSTEM_TIME
  mark(table, 4, 7, kCommand);      // PING, CHANGE_OPERATOR_CONTROL, its ACK, AUTH_KEY
  mark(table, 11, 11, kCommand);    // SET_MODE
  mark(table, 20, 23, kCommand);    // PARAM_*
  mark(table, 37, 55, kCommand);    // MISSION_* and its relatives
  mark(table, 66, 67, kCommand);    // data streams
  mark(table, 73, 77, kCommand);    // MISSION_ITEM_INT, COMMAND_INT, _LONG, _ACK
  mark(table, 80, 80, kCommand);    // COMMAND_CANCEL
  mark(table, 110, 111, kCommand);  // FILE_TRANSFER_PROTOCOL, TIMESYNC
  mark(table, 117, 122, kCommand);  // LOG_* transfer
  mark(table, 126, 126, kCommand);  // SERIAL_CONTROL
  mark(table, 148, 148, kCommand);  // AUTOPILOT_VERSION
  mark(table, 242, 243, kCommand);  // HOME_POSITION, SET_HOME_POSITION
  mark(table, 253, 253, kCommand);  // STATUSTEXT
  mark(table, 256, 256, kCommand);  // SETUP_SIGNING
  mark(table, 300, 300, kCommand);  // PROTOCOL_VERSION
  mark(table, 320, 324, kCommand);  // PARAM_EXT_*
  constexpr auto kSetpoint = TrafficClass::kSetpoint;
  mark(table, 69, 70, kSetpoint);             // MANUAL_CONTROL, RC_CHANNELS_OVERRIDE
  mark(table, 82, 82, kSetpoint);             // SET_ATTITUDE_TARGET
  mark(table, 84, 84, kSetpoint);             // SET_POSITION_TARGET_LOCAL_NED
  mark(table, 86, 86, kSetpoint);             // SET_POSITION_TARGET_GLOBAL_INT
  mark(table, 139, 139, kSetpoint);           // SET_ACTUATOR_CONTROL_TARGET
  mark(table, 90, 93, TrafficClass::kHil);    // HIL_STATE .. HIL_ACTUATOR_CONTROLS
  mark(table, 107, 107, TrafficClass::kHil);  // HIL_SENSOR
  mark(table, 114, 115, TrafficClass::kHil);  // HIL_OPTICAL_FLOW, HIL_STATE_QUATERNION
  mark(table, 113, 113, TrafficClass::kGps);  // HIL_GPS
  mark(table, 232, 232, TrafficClass::kGps);  // GPS_INPUT
  mark(table, 132, 132, TrafficClass::kGps);  // DISTANCE_SENSOR
  return table;
}

constexpr ClassTable kClasses = make_class_table();

}  // namespace

TrafficClass classify(std::uint32_t message_id) {
  return message_id < kTabledIds ? kClasses[message_id] : TrafficClass::kTelemetry;
}

std::string_view to_string(TrafficClass traffic) {
  constexpr base::EnumWords<TrafficClass::kTelemetry> kWords{"command", "hil", "gps", "setpoint",
                                                             "telemetry"};
  return kWords[traffic];
}

namespace {

/// Whether the extension `id` of HIL_SENSOR or HIL_GPS is there and not 0.
bool is_of_further_sensor(const mav::PacketView& packet) {
  // In both messages the id is the first byte behind the fields of MAVLink 1.
  constexpr std::size_t kSensorId = 64;
  constexpr std::size_t kGpsId = 36;
  using namespace mavlink::common;  // NOLINT: two of its messages
  std::size_t at = 0;
  if (packet.message_id == HilSensor::kId) at = kSensorId;
  if (packet.message_id == HilGps::kId) at = kGpsId;
  return at > 0 && packet.payload.size() > at && packet.payload[at] != 0;
}

}  // namespace

std::optional<std::uint64_t> hil_time_usec(const mav::PacketView& packet) {
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
  if (is_of_further_sensor(packet)) return std::nullopt;
  // The time leads the payload of all four; zeros at the end may be cut off.
  std::array<std::uint8_t, sizeof(std::uint64_t)> bytes{};
  if (packet.payload.size() >= bytes.size()) {
    std::copy_n(packet.payload.begin(), bytes.size(), bytes.begin());  // one load
  } else {
    std::ranges::copy(packet.payload, bytes.begin());
  }
  std::uint64_t stamp = 0;
  mav::get<std::uint64_t>(bytes.data(), stamp);
  return stamp;
}

PacketInfo inspect(const mav::PacketView& packet, const mav::MessageTable& table) {
  PacketInfo info;
  info.message_id = packet.message_id;
  info.source = packet.source;
  info.traffic = classify(packet.message_id);
  info.hil_time_usec = hil_time_usec(packet).value_or(0);
  if (const mav::MessageInfo* known = table.find(packet.message_id)) {
    info.target = mav::target_of(packet, *known);
  }
  return info;
}

}  // namespace cas::casd
