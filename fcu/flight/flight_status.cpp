// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/flight_status.hpp"

#include <array>

namespace cas::fcu {

namespace {

struct ModeEntry {
  FlightMode mode;
  std::string_view name;
  std::uint8_t main_mode;
  std::uint8_t sub_mode;
};

// PX4's numbers. Termination shows as TERMINATION's own main mode of newer releases would not be
// understood by older ground stations: they see it in HEARTBEAT.system_status.
constexpr std::array<ModeEntry, 10> kModes{{
    {FlightMode::kStabilized, "STABILIZED", 7, 0},
    {FlightMode::kAltitude, "ALTCTL", 2, 0},
    {FlightMode::kPosition, "POSCTL", 3, 0},
    {FlightMode::kOffboard, "OFFBOARD", 6, 0},
    {FlightMode::kTakeoff, "TAKEOFF", 4, 2},
    {FlightMode::kHold, "HOLD", 4, 3},
    {FlightMode::kMission, "MISSION", 4, 4},
    {FlightMode::kReturn, "RTL", 4, 5},
    {FlightMode::kLand, "LAND", 4, 6},
    {FlightMode::kTermination, "TERMINATION", 10, 0},
}};

const ModeEntry& entry(FlightMode mode) {
  for (const ModeEntry& candidate : kModes) {
    if (candidate.mode == mode) return candidate;
  }
  return kModes[5];
}

}  // namespace

std::uint32_t px4_custom_mode(FlightMode mode) {
  const ModeEntry& e = entry(mode);
  return static_cast<std::uint32_t>(e.main_mode) << 16U | static_cast<std::uint32_t>(e.sub_mode)
                                                              << 24U;
}

std::optional<FlightMode> flight_mode_from_px4(std::uint8_t main_mode, std::uint8_t sub_mode) {
  for (const ModeEntry& candidate : kModes) {
    if (candidate.mode == FlightMode::kTermination) continue;
    if (candidate.main_mode == main_mode && (main_mode != 4 || candidate.sub_mode == sub_mode)) {
      return candidate.mode;
    }
  }
  return std::nullopt;
}

std::optional<FlightMode> flight_mode_from_custom(std::uint32_t custom_mode) {
  return flight_mode_from_px4(static_cast<std::uint8_t>(custom_mode >> 16U),
                              static_cast<std::uint8_t>(custom_mode >> 24U));
}

std::string_view name(FlightMode mode) { return entry(mode).name; }

bool is_manual(FlightMode mode) {
  return mode == FlightMode::kStabilized || mode == FlightMode::kAltitude ||
         mode == FlightMode::kPosition;
}

bool needs_position(FlightMode mode) {
  switch (mode) {
    case FlightMode::kStabilized:
    case FlightMode::kAltitude:
    case FlightMode::kLand:
    case FlightMode::kTermination:
      return false;
    default:
      return true;
  }
}

}  // namespace cas::fcu
