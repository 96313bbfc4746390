// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/geofence.hpp"

#include <algorithm>
#include <array>

#include "base/suggestion.hpp"
#include "base/text.hpp"

namespace cas::hils {
namespace {

/// The same action in the words of scenarios, PX4 and ArduCopter.
struct ActionEntry {
  FenceAction action;
  std::string_view word;
  double gf_action;  ///< GF_ACTION of PX4 v1.12.0: 2 hold, 3 return, 5 land
  std::string_view px4_mode;
  double fence_action;  ///< FENCE_ACTION of ArduCopter 4.5: 1 RTL, 2 land, 4 brake
  std::string_view copter_mode;
};

constexpr std::array<ActionEntry, 3> kActions{{{FenceAction::kHold, "hold", 2, "HOLD", 4, "BRAKE"},
                                               {FenceAction::kReturn, "return", 3, "RTL", 1, "RTL"},
                                               {FenceAction::kLand, "land", 5, "LAND", 2, "LAND"}}};

/// Bits of ArduCopter's FENCE_TYPE.
constexpr double kCeiling = 1;
constexpr double kCircle = 2;

/// ArduCopter refuses to arm where FENCE_RADIUS is less than FENCE_MARGIN (2 m).
constexpr double kLeast_m = 3;
constexpr double kMost_m = 10'000;

const ActionEntry& entry(FenceAction action) {
  return *std::ranges::find(kActions, action, &ActionEntry::action);
}

FenceAction parse_action(const base::ConfigNode& node) {
  const auto word = node.as<std::string>();
  std::vector<std::string_view> known;
  for (const ActionEntry& each : kActions) {
    if (each.word == word) return each.action;
    known.push_back(each.word);
  }
  node.fail("a fence has the vehicle hold, return or land" + base::did_you_mean(word, known));
}

}  // namespace

Geofence parse_geofence(const base::ConfigNode& node) {
  Geofence fence;
  fence.radius_m = node.require_in("radius_m", kLeast_m, kMost_m);
  if (node.has("altitude_m")) fence.altitude_m = node.require_in("altitude_m", kLeast_m, kMost_m);
  fence.action = parse_action(node.at("action"));
  fence.margin_m = node.require_in("margin_m", 0.1, kMost_m);
  fence.early_m = node.get_in("early_m", std::min(fence.margin_m, fence.radius_m), 0.1, kMost_m);
  if (node.has("early_m") && fence.early_m >= fence.radius_m) {
    node.at("early_m").fail("must be less than radius_m, or any turn would do");
  }
  return fence;
}

FenceParams fence_params(std::string_view autopilot, const Geofence& fence) {
  const ActionEntry& action = entry(fence.action);
  if (autopilot == "PX4") {
    return {{"GF_MAX_HOR_DIST", fence.radius_m},
            {"GF_MAX_VER_DIST", fence.altitude_m.value_or(0)},  // 0: none
            {"GF_ACTION", action.gf_action}};
  }
  if (autopilot != "ArduPilot") return {};
  FenceParams params{{"FENCE_TYPE", kCircle + (fence.altitude_m ? kCeiling : 0)},
                     {"FENCE_RADIUS", fence.radius_m}};
  if (fence.altitude_m) params.emplace_back("FENCE_ALT_MAX", *fence.altitude_m);
  params.emplace_back("FENCE_ACTION", action.fence_action);
  params.emplace_back("FENCE_ENABLE", 1);
  return params;
}

std::string_view fence_mode(std::string_view autopilot, FenceAction action) {
  return autopilot == "PX4" ? entry(action).px4_mode : entry(action).copter_mode;
}

// PX4 v1.12.0: "Approaching on Geofence", "Maximum distance from home reached (15.00000)"; later:
// "Geofence: exceeding maximum distance to Home". ArduCopter 4.5: "Fence Breached"; later: "Circle
// fence breached".
bool tells_of_breach(std::string_view text) {
  const std::string low = base::lower(text);
  const auto has = [&low](std::string_view word) { return low.find(word) != std::string::npos; };
  if (has("cleared")) return false;
  if (has("fence")) return has("breach") || has("violat") || has("exceed") || has("approach");
  return has("from home reached") || has("above home reached");
}

}  // namespace cas::hils
