// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/ground_station_traffic.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "mavlink_gen/services/vehicle_heartbeat.hpp"

namespace cas::casd {
namespace {

// By kind; docs/reference/config.md sums them up.
constexpr std::string_view kGroundStationMessages[] = {
    "HEARTBEAT", "PING", "TIMESYNC", "SYSTEM_TIME", "STATUSTEXT", "AUTH_KEY", "SETUP_SIGNING",
    "CHANGE_OPERATOR_CONTROL", "SECURE_COMMAND",
    // commands and modes
    "COMMAND_INT", "COMMAND_LONG", "COMMAND_INT_STAMPED", "COMMAND_LONG_STAMPED", "COMMAND_ACK",
    "COMMAND_CANCEL", "SET_MODE", "REQUEST_DATA_STREAM", "REQUEST_EVENT",
    "AUTOPILOT_VERSION_REQUEST",
    // sticks and setpoints
    "MANUAL_CONTROL", "MANUAL_SETPOINT", "RC_CHANNELS_OVERRIDE", "RC_CHANNELS_OVERRIDE_V2",
    "SET_ATTITUDE_TARGET", "SET_POSITION_TARGET_LOCAL_NED", "SET_POSITION_TARGET_GLOBAL_INT",
    "SET_ACTUATOR_CONTROL_TARGET", "SET_VELOCITY_LIMITS", "FOLLOW_TARGET",
    // home and places
    "SET_HOME_POSITION", "SET_GPS_GLOBAL_ORIGIN", "SAFETY_SET_ALLOWED_AREA", "FENCE_POINT",
    "FENCE_FETCH_POINT", "RALLY_POINT", "RALLY_FETCH_POINT", "TERRAIN_DATA", "TERRAIN_CHECK",
    // parameters
    "PARAM_REQUEST_READ", "PARAM_REQUEST_LIST", "PARAM_SET", "PARAM_MAP_RC",
    "PARAM_EXT_REQUEST_READ", "PARAM_EXT_REQUEST_LIST", "PARAM_EXT_SET", "SET_MAG_OFFSETS",
    "OSD_PARAM_CONFIG", "OSD_PARAM_SHOW_CONFIG",
    // missions
    "MISSION_REQUEST_PARTIAL_LIST", "MISSION_WRITE_PARTIAL_LIST", "MISSION_ITEM",
    "MISSION_ITEM_INT", "MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_SET_CURRENT",
    "MISSION_REQUEST_LIST", "MISSION_COUNT", "MISSION_CLEAR_ALL", "MISSION_ACK",
    // files, logs, consoles, buses
    "FILE_TRANSFER_PROTOCOL", "LOG_REQUEST_LIST", "LOG_REQUEST_DATA", "LOG_ERASE",
    "LOG_REQUEST_END", "LOGGING_ACK", "REMOTE_LOG_BLOCK_STATUS", "DATA_TRANSMISSION_HANDSHAKE",
    "SERIAL_CONTROL", "DEVICE_OP_READ", "DEVICE_OP_WRITE", "CAN_FRAME", "CANFD_FRAME",
    "CAN_FILTER_MODIFY", "TUNNEL", "V2_EXTENSION",
    // corrections for the GPS receiver, traffic, identification
    "GPS_RTCM_DATA", "GPS_INJECT_DATA", "ADSB_VEHICLE", "OPEN_DRONE_ID_BASIC_ID",
    "OPEN_DRONE_ID_SELF_ID", "OPEN_DRONE_ID_SYSTEM", "OPEN_DRONE_ID_SYSTEM_UPDATE",
    "OPEN_DRONE_ID_OPERATOR_ID",
    // cameras, gimbals, lights, tunes, radios
    "DIGICAM_CONFIGURE", "DIGICAM_CONTROL", "MOUNT_CONFIGURE", "MOUNT_CONTROL",
    "GIMBAL_MANAGER_SET_ATTITUDE", "GIMBAL_MANAGER_SET_PITCHYAW",
    "GIMBAL_MANAGER_SET_MANUAL_CONTROL", "GOPRO_GET_REQUEST", "GOPRO_SET_REQUEST", "LED_CONTROL",
    "LED_STRIP_CONFIG", "PLAY_TUNE", "PLAY_TUNE_V2", "WIFI_CONFIG_AP", "CELLULAR_CONFIG"};

// The messages of the list above that vehicles send, too.
constexpr std::string_view kAlsoOfVehicles[] = {"HEARTBEAT",
                                                "SYSTEM_TIME",
                                                "STATUSTEXT",
                                                "COMMAND_ACK",
                                                "ADSB_VEHICLE",
                                                "OPEN_DRONE_ID_SYSTEM",
                                                "OPEN_DRONE_ID_BASIC_ID",
                                                "OPEN_DRONE_ID_SELF_ID",
                                                "OPEN_DRONE_ID_OPERATOR_ID"};

std::vector<std::uint32_t> ids_of(std::span<const std::string_view> names) {
  std::vector<std::uint32_t> ids;
  for (const std::string_view name : names) {
    const mav::MessageInfo* message = mav::public_table().find(name);
    CAS_CHECK(message != nullptr);
    ids.push_back(message->id);
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace

std::span<const std::uint32_t> ground_station_messages() {
  static const std::vector<std::uint32_t> ids = ids_of(kGroundStationMessages);
  return ids;
}

bool is_ground_station_traffic(const mav::PacketView& packet) {
  const auto ids = ground_station_messages();
  if (!std::binary_search(ids.begin(), ids.end(), packet.message_id)) return false;
  const auto heartbeat = mav::decode<mavlink::common::Heartbeat>(packet);
  return !heartbeat || !mav::services::is_vehicle(packet.source, *heartbeat);
}

bool may_be_of_vehicle(std::uint32_t message_id) {
  static const std::vector<std::uint32_t> shared = ids_of(kAlsoOfVehicles);
  const auto ids = ground_station_messages();
  return !std::binary_search(ids.begin(), ids.end(), message_id) ||
         std::binary_search(shared.begin(), shared.end(), message_id);
}

bool is_vehicle_traffic(const mav::PacketView& packet) {
  if (!may_be_of_vehicle(packet.message_id)) return false;
  const auto heartbeat = mav::decode<mavlink::common::Heartbeat>(packet);
  return !heartbeat || heartbeat->type != mavlink::common::MavType::kGcs;
}

}  // namespace cas::casd
