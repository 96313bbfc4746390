// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "mavlink/common/enums.hpp"

namespace cas::mav::services {

class VehicleState;

/// A MAVLink command without its addressee.
struct VehicleCommand {
  mavlink::common::MavCmd id{};
  std::array<float, 7> params{};  ///< 1..7; with a place, 5..7 are unused

  /// Set for COMMAND_INT: latitude and longitude in 1e-7 degree, altitude in m AMSL.
  struct Place {
    std::int32_t lat_deg_e7 = 0;
    std::int32_t lon_deg_e7 = 0;
    float alt_m = 0;
  };
  std::optional<Place> place{};
};

/// A command's name for people: "MAV_CMD 400 (arm or disarm)".
std::string describe(mavlink::common::MavCmd id);
/// "denied", "temporarily rejected", ...
std::string describe(mavlink::common::MavResult result);

/// MAV_CMD_COMPONENT_ARM_DISARM. @param force  against the vehicle's own checks
VehicleCommand arm_command(bool arm, bool force);
/// MAV_CMD_DO_SET_MODE with the armed and HIL flags as they are.
/// @param mode  HEARTBEAT.custom_mode, as custom_mode() gives it
VehicleCommand mode_command(const VehicleState& state, std::uint32_t mode);
/// A command whose unused parameters mean "as it is": NaN for PX4, zero for ArduPilot.
VehicleCommand here_command(const VehicleState& state, mavlink::common::MavCmd id);
/// MAV_CMD_REQUEST_MESSAGE: the vehicle sends this message once.
VehicleCommand request_command(std::uint32_t message_id);
/// MAV_CMD_SET_MESSAGE_INTERVAL. @param period_us  0 the vehicle's default, negative off
VehicleCommand interval_command(std::uint32_t message_id, double period_us);

/// Whether a command may start motors, takeoffs among them.
bool spins(const VehicleCommand& command);
/// Whether a command disarms or ends the flight, or may do so: PX4 rounds the parameter to 0 or 1.
bool stops(const VehicleCommand& command);

}  // namespace cas::mav::services
