// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/flight/geofence.hpp"
#include "hils/measure/limit_check.hpp"
#include "hils/measure/tracking.hpp"

namespace cas::hils {

/// Figures of a vehicle at the fence of its autopilot.
struct FenceFigures {
  std::string words{};  ///< with which it announced the breach; empty: it did not
  std::optional<std::string> not_restored{};  ///< parameters that it did not take back
  /// By the truth, from where the vehicle stood; nullopt where that was not recorded.
  std::optional<double> farthest_m{};  ///< horizontal
  std::optional<double> highest_m{};
};

/// Takes in how far the true flight went.
void add_reach(std::span<const PoseSample> truth, FenceFigures& figures);

/// Checks of a flight to the fence: the vehicle came to it, the autopilot announced it, the truth
/// stays within the fence and its margin, and the parameters are restored.
/// @param flown  the steps as they went, with the one under way: a breach that did not begin is not
///   judged
std::vector<LimitCheck> fence_checks(const Geofence& fence, const FenceFigures& figures,
                                     std::span<const Stage> flown);

/// The fence as a version of the firmware keeps it: only PX4 before v1.13 looks ahead by its way to
/// a stop; since then GF_PREDICT is off by default, and ArduPilot never does.
Geofence kept_by(const std::string& version, Geofence fence);

/// For summary.json.
nlohmann::json fence_json(const FenceFigures& figures);

}  // namespace cas::hils
