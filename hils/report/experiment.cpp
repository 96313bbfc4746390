// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/experiment.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/enum_words.hpp"

namespace cas::hils {

namespace {

const FlightStep* measured_step(const Measurement& figures) {
  const auto found =
      std::ranges::find_if(figures.stages, [](const Stage& stage) { return stage.step.measure; });
  return found == figures.stages.end() ? nullptr : &found->step;
}

bool has(const Measurement& figures, StepKind kind) {
  return std::ranges::any_of(figures.stages,
                             [kind](const Stage& stage) { return stage.step.kind == kind; });
}

std::string shape_name(fcu::PatternShape shape) {
  constexpr base::EnumWords<fcu::PatternShape::kSteps> kWords{"trajectory", "circle",
                                                              "figure eight", "step response"};
  return std::string(kWords[shape]);
}

std::string kind_of(const Measurement& figures) {
  if (!figures.responses.empty()) return "step responses";
  for (const Stage& stage : figures.stages) {
    if (stage.step.kind == StepKind::kTrajectory) return shape_name(stage.step.trajectory.shape);
  }
  if (has(figures, StepKind::kLoiter)) return shape_name(fcu::PatternShape::kCircle);
  return has(figures, StepKind::kGoto) ? "flight from place to place" : "hover";
}

}  // namespace

std::string experiment_of(const Measurement& figures) {
  return kind_of(figures) + (figures.faults.empty() ? "" : " with faults");
}

std::string how_it_ran(const Measurement& figures) {
  if (figures.firmware) {
    const FirmwareRecord& firmware = *figures.firmware;
    const std::string name = firmware.autopilot.empty() ? "firmware" : firmware.autopilot;
    return fmt::format("stock {}{}{}", name, firmware.version.empty() ? "" : " v",
                       firmware.version) +
           (figures.streamed ? " in HITL"
            : firmware.ahrs  ? " by External AHRS"
                             : " in software");
  }
  return title_of(figures.architecture) + (figures.lockstep        ? " in lockstep"
                                           : figures.virtual_clock ? " on the virtual clock"
                                                                   : "");
}

std::optional<std::string> unjudged_failure(const Measurement& figures, const Verdict& verdict) {
  if (verdict.valid || !figures.flight_failure) return std::nullopt;
  return "Not judged: the flight was not completed: " + *figures.flight_failure;
}

std::string controller_name(const Measurement& figures) {
  const bool has_name = figures.firmware && !figures.firmware->autopilot.empty();
  return has_name ? figures.firmware->autopilot : title_of(figures.architecture);
}

bool measures_station_keeping(const Measurement& figures) {
  if (figures.firmware) return false;
  const FlightStep* step = measured_step(figures);
  return step == nullptr || step->kind != StepKind::kTrajectory;
}

std::string measured_part(const Measurement& figures) {
  if (!figures.over_hold) return "whole flight";
  const FlightStep* step = measured_step(figures);
  if (step != nullptr && step->kind == StepKind::kTrajectory) {
    const std::string shape = shape_name(step->trajectory.shape);
    return step->name.empty() ? shape : fmt::format("{} '{}'", shape, step->name);
  }
  if (has(figures, StepKind::kLoiter)) return kind_of(figures);
  return kind_of(figures) == "hover" ? "hover" : "hold";
}

std::string report_title(const Measurement& figures) {
  const std::string kind = experiment_of(figures);
  const std::string scenario =
      figures.scenario == kind ? kind : fmt::format("{}: {}", figures.scenario, kind);
  return fmt::format("{}, {}", scenario, controller_name(figures));
}

}  // namespace cas::hils
