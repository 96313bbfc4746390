// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/flight_status.hpp"

#include <algorithm>
#include <array>

#include "base/error.hpp"
#include "mavlink_gen/services/px4_modes.hpp"

namespace cas::fcu {

namespace {

using namespace mav::services;  // NOLINT: its table of modes

struct ModeEntry {
  FlightMode mode;
  const FlightModeWord& px4;
};

constexpr std::array<ModeEntry, 10> kModes{{
    {FlightMode::kStabilized, px4_mode("STABILIZED")},
    {FlightMode::kAltitude, px4_mode("ALTCTL")},
    {FlightMode::kPosition, px4_mode("POSCTL")},
    {FlightMode::kOffboard, px4_mode("OFFBOARD")},
    {FlightMode::kTakeoff, px4_mode("TAKEOFF")},
    {FlightMode::kHold, px4_mode("HOLD")},
    {FlightMode::kMission, px4_mode("MISSION")},
    {FlightMode::kReturn, px4_mode("RTL")},
    {FlightMode::kLand, px4_mode("LAND")},
    {FlightMode::kTermination, px4_mode("TERMINATION")},
}};

const FlightModeWord& px4_of(FlightMode mode) {
  const auto found = std::ranges::find(kModes, mode, &ModeEntry::mode);
  CAS_CHECK(found != kModes.end());
  return found->px4;
}

}  // namespace

std::uint32_t px4_custom_mode(FlightMode mode) { return px4_of(mode).number; }

std::optional<FlightMode> flight_mode_from_custom(std::uint32_t custom_mode) {
  const std::uint32_t main = px4_main(custom_mode);
  for (const auto& [mode, px4] : kModes) {
    if (mode == FlightMode::kTermination || px4_main(px4.number) != main) continue;
    if (main != kPx4Auto || px4_sub(px4.number) == px4_sub(custom_mode)) return mode;
  }
  return std::nullopt;
}

std::string_view name(FlightMode mode) { return px4_of(mode).word; }

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
