// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/fence_verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "hils/measure/judgement.hpp"
#include "hils/scenario/firmware.hpp"

namespace cas::hils {
namespace {

LimitCheck fact(const char* what, const char* wanted, bool kept, const std::string& missed) {
  return {.what = what,
          .found = kept ? wanted : missed,
          .wanted = wanted,
          .kept = kept,
          .sentence = kept ? "" : missed};
}

/// Whether the vehicle was where the fence is: a mode changed far inside says nothing of it.
bool came_to(const Geofence& fence, const FenceFigures& figures) {
  const bool far = figures.farthest_m && *figures.farthest_m >= fence.radius_m - fence.early_m;
  const bool high = fence.altitude_m && figures.highest_m &&
                    *figures.highest_m >= *fence.altitude_m - fence.early_m;
  return far || high;
}

bool is_breach(const Stage& stage) { return stage.step.kind == StepKind::kBreach; }

}  // namespace

void add_reach(std::span<const PoseSample> truth, FenceFigures& figures) {
  if (truth.empty()) return;
  const Pose& start = truth.front().pose;
  double farthest_m = 0;
  double highest_m = 0;
  for (const PoseSample& sample : truth) {
    farthest_m =
        std::max(farthest_m, std::hypot(sample.pose.x_m - start.x_m, sample.pose.y_m - start.y_m));
    highest_m = std::max(highest_m, sample.pose.z_m - start.z_m);
  }
  figures.farthest_m = farthest_m;
  figures.highest_m = highest_m;
}

std::vector<LimitCheck> fence_checks(const Geofence& fence, const FenceFigures& figures,
                                     std::span<const Stage> flown) {
  std::vector<LimitCheck> checks;
  if (std::ranges::any_of(flown, is_breach)) {
    checks.push_back(fact("fence", "its breach was announced", !figures.words.empty(),
                          "the autopilot did not announce a breach of its fence"));
    checks.push_back(
        fact("way to the fence", "flown", came_to(fence, figures),
             fmt::format("the vehicle did not come within {:.1f} m of its fence: {} m "
                         "from home at most",
                         fence.early_m,
                         figures.farthest_m ? fmt::format("{:.2f}", *figures.farthest_m)
                                            : std::string("unknown"))));
  }
  const auto within = [&checks](const char* what, double bound_m, std::optional<double> value_m) {
    check_bound({.what = what, .unit = "m", .digits = 2, .bound = bound_m}, value_m, true, checks);
  };
  within("farthest from home", fence.radius_m + fence.margin_m, figures.farthest_m);
  if (fence.altitude_m) {
    within("highest above home", *fence.altitude_m + fence.margin_m, figures.highest_m);
  }
  checks.push_back(fact("parameters of the fence", "as before the flight", !figures.not_restored,
                        figures.not_restored.value_or("")));
  return checks;
}

Geofence kept_by(const std::string& version, Geofence fence) {
  const bool turns_at_it = !version.empty() && is_at_least(version, "1.13");
  if (turns_at_it) fence.early_m = std::min(fence.early_m, fence.margin_m);
  return fence;
}

nlohmann::json fence_json(const FenceFigures& figures) {
  nlohmann::json all{{"announced", figures.words}, {"parameters_restored", !figures.not_restored}};
  if (figures.farthest_m) all["farthest_m"] = *figures.farthest_m;
  if (figures.highest_m) all["highest_m"] = *figures.highest_m;
  return all;
}

}  // namespace cas::hils
