// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "casd/station/vehicle_state.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::casd {

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

/// "MAV_CMD 400 (arm or disarm)": what people call a command.
std::string describe(mavlink::common::MavCmd id);
/// "denied", "temporarily rejected", ...
std::string describe(mavlink::common::MavResult result);

/// MAV_CMD_COMPONENT_ARM_DISARM. @param force  against the vehicle's own checks
VehicleCommand arm_command(bool arm, bool force);
/// MAV_CMD_DO_SET_MODE with the armed and HIL flags as they are.
VehicleCommand mode_command(const VehicleState& state, std::uint32_t mode);
/// A command whose unused parameters mean "as it is": NaN for PX4, zero for ArduPilot.
VehicleCommand here_command(const VehicleState& state, mavlink::common::MavCmd id);
/// MAV_CMD_REQUEST_MESSAGE: the vehicle sends this message once.
VehicleCommand request_command(std::uint32_t message_id);
/// MAV_CMD_SET_MESSAGE_INTERVAL. @param period_us  0 the vehicle's default, negative off
VehicleCommand interval_command(std::uint32_t message_id, double period_us);
/// MAV_CMD_DO_REPOSITION to a place relative to home, in m; without a yaw the heading is kept.
VehicleCommand reposition_command(const HomeAmsl& home, double north_m, double east_m,
                                  double down_m, std::optional<double> yaw_deg);

/// Whether a command may start motors.
bool spins(const VehicleCommand& command);

}  // namespace cas::casd
