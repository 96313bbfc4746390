// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "mavlink_gen/services/flight_mode_word.hpp"

namespace cas::mav::services {

inline constexpr std::uint32_t kPx4Auto = 4;  ///< main mode whose sub modes are modes of their own

constexpr std::uint32_t px4_main(std::uint32_t custom_mode) { return custom_mode >> 16U & 0xFFU; }
constexpr std::uint32_t px4_sub(std::uint32_t custom_mode) { return custom_mode >> 24U; }
/// custom_mode of PX4: main mode in bits 16-23, sub mode in bits 24-31.
constexpr std::uint32_t px4_number(std::uint32_t main, std::uint32_t sub = 0) {
  return main << 16U | sub << 24U;
}

/// PX4's modes. Source: PX4's px4_custom_mode.h and VehicleStatus.msg. The first word of a number
/// is the one shown.
inline constexpr auto kPx4Modes = std::to_array<FlightModeWord>({
    {"MANUAL", px4_number(1), true, 0},
    {"ALTCTL", px4_number(2), true, 1},
    {"POSCTL", px4_number(3), true, 2},
    {"ACRO", px4_number(5), true, 10},
    {"OFFBOARD", px4_number(6), true, 14},
    {"STABILIZED", px4_number(7), true, 15},
    {"READY", px4_number(kPx4Auto, 1)},
    {"TAKEOFF", px4_number(kPx4Auto, 2), true, 17},
    {"HOLD", px4_number(kPx4Auto, 3), true, 4},
    {"LOITER", px4_number(kPx4Auto, 3)},
    {"MISSION", px4_number(kPx4Auto, 4), true, 3},
    {"RTL", px4_number(kPx4Auto, 5), true, 5},
    {"LAND", px4_number(kPx4Auto, 6), true, 18},
    {"PRECLAND", px4_number(kPx4Auto, 9), true, 20},
    {"FOLLOW", px4_number(kPx4Auto, 8), true, 19},
    {"ORBIT", px4_number(3, 1), false, 21},
    {"SLOW", px4_number(3, 2), false, 6},
    {"DESCEND", px4_number(kPx4Auto, 6), false, 12},
    {"VTOL_TAKEOFF", px4_number(kPx4Auto, 10), false, 22},
    {"TERMINATION", px4_number(10), false, 13},
});

/// The mode of a word that the table has.
consteval const FlightModeWord& px4_mode(std::string_view word) {
  return *std::ranges::find(kPx4Modes, word, &FlightModeWord::word);
}

/// vehicle_status.nav_state of a custom_mode; nullopt for a mode that has none. A sub mode that the
/// table does not know counts as its main mode, but for those of AUTO.
constexpr std::optional<std::uint8_t> px4_nav_state(std::uint32_t custom_mode) {
  const auto found = std::ranges::find(kPx4Modes, custom_mode, &FlightModeWord::number);
  if (found != kPx4Modes.end()) return found->nav_state;
  if (px4_main(custom_mode) == kPx4Auto || px4_sub(custom_mode) == 0) return std::nullopt;
  return px4_nav_state(px4_number(px4_main(custom_mode)));
}

/// Word of a nav_state; empty for one that the table does not know.
constexpr std::string_view px4_mode_word(std::uint8_t nav_state) {
  const auto found =
      std::ranges::find(kPx4Modes, std::optional(nav_state), &FlightModeWord::nav_state);
  return found == kPx4Modes.end() ? std::string_view() : found->word;
}

}  // namespace cas::mav::services
