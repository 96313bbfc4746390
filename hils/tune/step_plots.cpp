// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/step_plots.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "hils/measure/tracking.hpp"
#include "hils/scenario/scenario.hpp"
#include "hils/sweep/sweep_folder.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

/// When a step of that name of the first vehicle began and ended, by summary.json; s.
std::optional<std::pair<double, double>> stage_of(const fs::path& flight, const std::string& name) {
  const auto summary = nlohmann::json::parse(text_of_file(flight / "summary.json"), nullptr, false);
  const nlohmann::json::json_pointer stages("/vehicles/0/stages");
  if (!summary.is_object() || !summary.contains(stages)) return std::nullopt;
  for (const auto& stage : summary[stages]) {
    if (stage.value("name", "") != name) continue;
    return std::pair{stage.value("begin_s", 0.0), stage.value("end_s", 0.0)};
  }
  return std::nullopt;
}

Series response(const fs::path& flight, const std::string& name, double half_s) {
  Series series{.name = flight.parent_path().filename().string(), .points = {}};
  try {
    const auto stage = stage_of(flight, name);
    if (!stage) return series;
    const std::vector<PoseSample> truth = read_truth(flight / "truth.csv");
    const double begin_s = stage->first + half_s;
    const auto samples =
        between(truth, std::llround((begin_s - 1) * 1e6), std::llround(stage->second * 1e6));
    for (const PoseSample& sample : samples) {
      series.points.emplace_back(1e-6 * static_cast<double>(sample.time_us) - begin_s,
                                 sample.pose.x_m - truth.front().pose.x_m);
    }
  } catch (const base::ConfigError&) {
    // the flight left nothing to draw
  }
  return series;
}

}  // namespace

std::vector<Plot> step_plots(const fs::path& scenario, const fs::path& before,
                             const fs::path& after) {
  const Scenario flown = Scenario::load(scenario);
  std::vector<Plot> plots;
  for (const FlightStep& step : flown.steps) {
    if (step.kind != StepKind::kTrajectory || step.trajectory.shape != fcu::PatternShape::kSteps) {
      continue;
    }
    const std::string name(phase_of(step));
    Plot plot{.title = after.filename().string() + ", " + name,
              .x_label = "time since the step, s",
              .y_label = "north, m"};
    for (const fs::path& flight : {before, after}) {
      Series series = response(flight, name, step.trajectory.period_s);
      if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    if (!plot.series.empty()) plots.push_back(std::move(plot));
  }
  return plots;
}

}  // namespace cas::hils
