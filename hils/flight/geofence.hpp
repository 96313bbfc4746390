// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config/config.hpp"

namespace cas::hils {

/// Action of an autopilot at its own fence.
enum class FenceAction { kHold, kReturn, kLand };

/// A fence that a stock autopilot keeps by itself: an upright cylinder about its home.
struct Geofence {
  double radius_m = 0;
  std::optional<double> altitude_m{};  ///< ceiling above home; nullopt: none
  FenceAction action = FenceAction::kReturn;
  double margin_m = 0;  ///< so far beyond it the vehicle may come by the truth
  /// So far inside it the vehicle may turn; PX4 from v1.13 on by `margin_m` at most.
  double early_m = 0;
};

/// Reads the section `geofence` of a scenario of stock firmware. @throws base::ConfigError
Geofence parse_geofence(const base::ConfigNode& node);

/// Parameters by name, in the order in which they are set.
using FenceParams = std::vector<std::pair<std::string, double>>;
/// The fence in the parameters of an autopilot; the one that puts it in force comes last.
/// @param autopilot  "PX4" or "ArduPilot"; of others nothing
FenceParams fence_params(std::string_view autopilot, const Geofence& fence);
/// Flight mode, by casd's word, into which a breach takes the vehicle.
std::string_view fence_mode(std::string_view autopilot, FenceAction action);
/// Whether a STATUSTEXT of PX4 or ArduCopter announces that the vehicle breaches its fence.
bool tells_of_breach(std::string_view text);

}  // namespace cas::hils
