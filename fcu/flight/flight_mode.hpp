// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace cas::fcu {

/// What the controller does with the vehicle. Names and wire numbers are PX4's.
enum class FlightMode : std::uint8_t {
  kStabilized,  ///< pilot: tilt, yaw rate, thrust
  kAltitude,    ///< pilot: tilt, yaw rate, climb rate
  kPosition,    ///< pilot: velocity, yaw rate; holds when the sticks are centred
  kOffboard,    ///< a companion streams setpoints
  kTakeoff,
  kHold,
  kMission,
  kReturn,
  kLand,
  kTermination,  ///< rotors stopped, for good
};

/// HEARTBEAT.custom_mode: main mode in bits 16-23, sub mode in bits 24-31.
std::uint32_t px4_custom_mode(FlightMode mode);
/// The mode behind PX4's main and sub mode, or nothing where this controller has no such mode.
std::optional<FlightMode> flight_mode_from_px4(std::uint8_t main_mode, std::uint8_t sub_mode);
std::optional<FlightMode> flight_mode_from_custom(std::uint32_t custom_mode);
/// "HOLD", "TAKEOFF" ...
std::string_view name(FlightMode mode);

/// Flown by sticks.
bool is_manual(FlightMode mode);
/// Needs a horizontal position estimate.
bool needs_position(FlightMode mode);

}  // namespace cas::fcu
