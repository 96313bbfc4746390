// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/vehicle_modes.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <span>

#include "mavlink_gen/services/ardupilot_modes.hpp"
#include "mavlink_gen/services/px4_modes.hpp"

namespace cas::mav::services {
namespace {

using mavlink::common::MavAutopilot;
using mavlink::common::MavModeFlag;
using mavlink::common::MavType;

std::span<const FlightModeWord> modes(ModeSet set) {
  switch (set) {
    case ModeSet::kPx4:
      return kPx4Modes;
    case ModeSet::kCopter:
      return kCopterModes;
    case ModeSet::kPlane:
      return kPlaneModes;
    case ModeSet::kRover:
      return kRoverModes;
    case ModeSet::kSub:
      return kSubModes;
    case ModeSet::kNone:
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

ModeSet mode_set(Autopilot autopilot, MavType type) {
  if (autopilot == Autopilot::kPx4) return ModeSet::kPx4;
  if (autopilot != Autopilot::kArduPilot) return ModeSet::kNone;
  switch (type) {
    case MavType::kQuadrotor:
    case MavType::kCoaxial:
    case MavType::kHelicopter:
    case MavType::kHexarotor:
    case MavType::kOctorotor:
    case MavType::kTricopter:
    case MavType::kDodecarotor:
    case MavType::kDecarotor:
      return ModeSet::kCopter;
    case MavType::kGroundRover:
    case MavType::kSurfaceBoat:
      return ModeSet::kRover;
    case MavType::kSubmarine:
      return ModeSet::kSub;
    default:
      break;
  }
  const bool vtol = type >= MavType::kVtolTailsitterDuorotor && type <= MavType::kVtolReserved5;
  return type == MavType::kFixedWing || vtol ? ModeSet::kPlane : ModeSet::kNone;
}

std::string mode_name(ModeSet set, MavModeFlag base_mode, std::uint32_t custom_mode) {
  if (!has(base_mode, MavModeFlag::kCustomModeEnabled)) {
    return hex("base 0x%02x", static_cast<std::uint32_t>(base_mode));
  }
  for (const FlightModeWord& mode : modes(set)) {
    if (mode.number == custom_mode) return std::string(mode.word);
  }
  return hex("custom 0x%08x", custom_mode);
}

std::optional<std::uint32_t> custom_mode(ModeSet set, std::string_view word) {
  std::string upper(word);
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  for (const FlightModeWord& mode : modes(set)) {
    if (mode.asked_for && mode.word == upper) return mode.number;
  }
  return std::nullopt;
}

std::vector<std::string_view> mode_words(ModeSet set) {
  std::vector<std::string_view> words;
  for (const FlightModeWord& mode : modes(set)) {
    if (mode.asked_for) words.push_back(mode.word);
  }
  return words;
}

ModeParams mode_params(Autopilot autopilot, std::uint32_t custom_mode) {
  if (autopilot != Autopilot::kPx4) return {.main = static_cast<float>(custom_mode), .sub = 0};
  return {.main = static_cast<float>(px4_main(custom_mode)),
          .sub = static_cast<float>(px4_sub(custom_mode))};
}

}  // namespace cas::mav::services
