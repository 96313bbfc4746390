// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "mavlink_gen/services/flight_mode_word.hpp"

namespace cas::mav::services {

// Modes of ArduPilot's vehicles, whose numbers mean other modes on another vehicle.

/// Source: ArduPilot's ArduCopter/mode.h.
inline constexpr auto kCopterModes = std::to_array<FlightModeWord>({
    {"STABILIZE", 0}, {"ACRO", 1},          {"ALT_HOLD", 2},   {"AUTO", 3},      {"GUIDED", 4},
    {"LOITER", 5},    {"RTL", 6},           {"CIRCLE", 7},     {"LAND", 9},      {"DRIFT", 11},
    {"SPORT", 13},    {"FLIP", 14},         {"AUTOTUNE", 15},  {"POSHOLD", 16},  {"BRAKE", 17},
    {"THROW", 18},    {"GUIDED_NOGPS", 20}, {"SMART_RTL", 21}, {"FLOWHOLD", 22}, {"FOLLOW", 23},
});

/// Source: ArduPilot's ArduPlane/mode.h. Those with Q are a quadplane's, on its rotors.
inline constexpr auto kPlaneModes = std::to_array<FlightModeWord>({
    {"MANUAL", 0},
    {"CIRCLE", 1},
    {"STABILIZE", 2},
    {"TRAINING", 3},
    {"ACRO", 4},
    {"FBWA", 5},
    {"FBWB", 6},
    {"CRUISE", 7},
    {"AUTOTUNE", 8},
    {"AUTO", 10},
    {"RTL", 11},
    {"LOITER", 12},
    {"TAKEOFF", 13},
    {"AVOID_ADSB", 14, false},
    {"GUIDED", 15},
    {"INITIALISING", 16, false},
    {"QSTABILIZE", 17},
    {"QHOVER", 18},
    {"QLOITER", 19},
    {"QLAND", 20},
    {"QRTL", 21},
    {"QAUTOTUNE", 22},
    {"QACRO", 23},
    {"THERMAL", 24},
    {"LOITER_ALT_QLAND", 25},
});

/// Source: ArduPilot's Rover/mode.h.
inline constexpr auto kRoverModes = std::to_array<FlightModeWord>({
    {"MANUAL", 0},
    {"ACRO", 1},
    {"STEERING", 3},
    {"HOLD", 4},
    {"LOITER", 5},
    {"FOLLOW", 6},
    {"SIMPLE", 7},
    {"DOCK", 8},
    {"CIRCLE", 9},
    {"AUTO", 10},
    {"RTL", 11},
    {"SMART_RTL", 12},
    {"GUIDED", 15},
    {"INITIALISING", 16, false},
});

/// Source: ArduPilot's ArduSub/mode.h.
inline constexpr auto kSubModes = std::to_array<FlightModeWord>({
    {"STABILIZE", 0},
    {"ACRO", 1},
    {"ALT_HOLD", 2},
    {"AUTO", 3},
    {"GUIDED", 4},
    {"CIRCLE", 7},
    {"SURFACE", 9},
    {"POSHOLD", 16},
    {"MANUAL", 19},
    {"MOTOR_DETECT", 20},
    {"SURFTRAK", 21},
});

}  // namespace cas::mav::services
