// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "mavlink_gen/services/flight_mode_word.hpp"

namespace cas::mav::services {

/// ArduCopter's modes. Source: ArduPilot's ArduCopter/mode.h.
inline constexpr auto kCopterModes = std::to_array<FlightModeWord>({
    {"STABILIZE", 0}, {"ACRO", 1},          {"ALT_HOLD", 2},   {"AUTO", 3},      {"GUIDED", 4},
    {"LOITER", 5},    {"RTL", 6},           {"CIRCLE", 7},     {"LAND", 9},      {"DRIFT", 11},
    {"SPORT", 13},    {"FLIP", 14},         {"AUTOTUNE", 15},  {"POSHOLD", 16},  {"BRAKE", 17},
    {"THROW", 18},    {"GUIDED_NOGPS", 20}, {"SMART_RTL", 21}, {"FLOWHOLD", 22}, {"FOLLOW", 23},
});

}  // namespace cas::mav::services
