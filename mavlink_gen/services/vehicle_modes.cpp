// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/vehicle_modes.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <span>

namespace cas::mav::services {
namespace {

using mavlink::common::MavAutopilot;
using mavlink::common::MavModeFlag;

struct Mode {
  std::string_view word;
  std::uint32_t number;
  bool asked_for = true;  ///< can be set by its word; others are only shown
};

/// PX4: main mode in bits 16-23, sub mode of AUTO in bits 24-31.
constexpr std::uint32_t px4(std::uint32_t main, std::uint32_t sub = 0) {
  return main << 16 | sub << 24;
}
constexpr std::uint32_t kPx4Auto = 4;

// The first word of a number is the one shown.
constexpr Mode kPx4Modes[] = {
    {"MANUAL", px4(1)},
    {"ALTCTL", px4(2)},
    {"POSCTL", px4(3)},
    {"ACRO", px4(5)},
    {"OFFBOARD", px4(6)},
    {"STABILIZED", px4(7)},
    {"READY", px4(kPx4Auto, 1)},
    {"TAKEOFF", px4(kPx4Auto, 2)},
    {"HOLD", px4(kPx4Auto, 3)},
    {"LOITER", px4(kPx4Auto, 3)},
    {"MISSION", px4(kPx4Auto, 4)},
    {"RTL", px4(kPx4Auto, 5)},
    {"LAND", px4(kPx4Auto, 6)},
    {"PRECLAND", px4(kPx4Auto, 9)},
    {"FOLLOW", px4(kPx4Auto, 8)},
    {"ORBIT", px4(3, 1), false},
    {"TERMINATION", px4(10), false},
};

constexpr Mode kCopterModes[] = {
    {"STABILIZE", 0}, {"ACRO", 1},          {"ALT_HOLD", 2},   {"AUTO", 3},      {"GUIDED", 4},
    {"LOITER", 5},    {"RTL", 6},           {"CIRCLE", 7},     {"LAND", 9},      {"DRIFT", 11},
    {"SPORT", 13},    {"FLIP", 14},         {"AUTOTUNE", 15},  {"POSHOLD", 16},  {"BRAKE", 17},
    {"THROW", 18},    {"GUIDED_NOGPS", 20}, {"SMART_RTL", 21}, {"FLOWHOLD", 22}, {"FOLLOW", 23},
};

std::span<const Mode> modes(Autopilot autopilot) {
  switch (autopilot) {
    case Autopilot::kPx4:
      return kPx4Modes;
    case Autopilot::kArduPilot:
      return kCopterModes;
    case Autopilot::kOther:
      break;
  }
  return {};
}

std::string hex(const char* format, std::uint32_t value) {
  char text[24];
  std::snprintf(text, sizeof text, format, static_cast<unsigned>(value));
  return text;
}

}  // namespace

Autopilot autopilot_family(MavAutopilot wire) {
  if (wire == MavAutopilot::kPx4) return Autopilot::kPx4;
  if (wire == MavAutopilot::kArdupilotmega) return Autopilot::kArduPilot;
  return Autopilot::kOther;
}

std::string_view name(Autopilot autopilot) {
  switch (autopilot) {
    case Autopilot::kPx4:
      return "PX4";
    case Autopilot::kArduPilot:
      return "ArduPilot";
    case Autopilot::kOther:
      break;
  }
  return "other";
}

std::string mode_name(Autopilot autopilot, MavModeFlag base_mode, std::uint32_t custom_mode) {
  if (!has(base_mode, MavModeFlag::kCustomModeEnabled)) {
    return hex("base 0x%02x", static_cast<std::uint32_t>(base_mode));
  }
  for (const Mode& mode : modes(autopilot)) {
    if (mode.number == custom_mode) return std::string(mode.word);
  }
  return hex("custom 0x%08x", custom_mode);
}

std::optional<std::uint32_t> custom_mode(Autopilot autopilot, std::string_view word) {
  std::string upper(word);
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  for (const Mode& mode : modes(autopilot)) {
    if (mode.asked_for && mode.word == upper) return mode.number;
  }
  return std::nullopt;
}

std::string mode_words(Autopilot autopilot) {
  std::string words;
  for (const Mode& mode : modes(autopilot)) {
    if (!mode.asked_for) continue;
    if (!words.empty()) words += ' ';
    words += mode.word;
  }
  return words;
}

ModeParams mode_params(Autopilot autopilot, std::uint32_t custom_mode) {
  if (autopilot != Autopilot::kPx4) return {.main = static_cast<float>(custom_mode), .sub = 0};
  return {.main = static_cast<float>(custom_mode >> 16 & 0xff),
          .sub = static_cast<float>(custom_mode >> 24)};
}

}  // namespace cas::mav::services
