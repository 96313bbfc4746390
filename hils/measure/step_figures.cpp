// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/step_figures.hpp"

#include <algorithm>
#include <cmath>

namespace cas::hils {
namespace {

/// A vehicle hangs still that is slower than this when it begins to land.
constexpr double kHangsStill_m_s = 0.5;

const PoseSample& truth_at(std::span<const PoseSample> truth, std::int64_t time_us) {
  const auto next = std::ranges::lower_bound(truth, time_us, {}, &PoseSample::time_us);
  return next == truth.end() ? truth.back() : *next;
}

std::span<const PoseSample> flown_in(const Stage& stage, std::span<const PoseSample> truth) {
  return between(truth, to_microseconds(stage.begin), to_microseconds(stage.end));
}

}  // namespace

ReferenceAt circle_reference(const Stage& stage, std::span<const PoseSample> truth) {
  return [&stage, truth](std::int64_t time_us) {
    const Pose& start = truth.front().pose;
    Pose pose = truth_at(truth, time_us).pose;
    const double middle_x_m = start.x_m + stage.reference_m.x();
    const double middle_y_m = start.y_m + stage.reference_m.y();
    const double north = pose.x_m - middle_x_m;
    const double east = pose.y_m - middle_y_m;
    const double bearing_rad = std::atan2(east, north);
    pose.x_m = middle_x_m + stage.circle_m * std::cos(bearing_rad);
    pose.y_m = middle_y_m + stage.circle_m * std::sin(bearing_rad);
    pose.z_m = start.z_m + stage.reference_m.z();
    return pose;
  };
}

double radius_error_pct(const Stage& stage, std::span<const PoseSample> flown, const Pose& start) {
  double sum_m = 0;
  for (const PoseSample& sample : flown) {
    sum_m += std::hypot(sample.pose.x_m - start.x_m - stage.reference_m.x(),
                        sample.pose.y_m - start.y_m - stage.reference_m.y());
  }
  const double mean_m = sum_m / static_cast<double>(flown.size());
  return 100 * std::abs(mean_m / stage.circle_m - 1);
}

std::optional<double> least_airspeed_m_s(std::span<const PoseSample> samples) {
  std::optional<double> least;
  for (const PoseSample& sample : samples) {
    if (!sample.airspeed_m_s) continue;
    least = std::min(least.value_or(*sample.airspeed_m_s), *sample.airspeed_m_s);
  }
  return least;
}

std::optional<double> transition_height_m(const std::vector<Stage>& stages,
                                          std::span<const PoseSample> truth) {
  std::optional<double> most_m;
  for (const Stage& stage : stages) {
    if (stage.step.kind != StepKind::kTransition) continue;
    const auto flown = flown_in(stage, truth);
    for (const PoseSample& sample : flown) {
      const double off_m = std::abs(sample.pose.z_m - flown.front().pose.z_m);
      most_m = std::max(most_m.value_or(0), off_m);
    }
  }
  return most_m;
}

std::optional<double> landing_error_m(const std::vector<Stage>& stages,
                                      std::span<const PoseSample> truth) {
  std::optional<double> off_m;
  for (const Stage& stage : stages) {
    const auto flown = flown_in(stage, truth);
    if (stage.step.kind != StepKind::kLand || flown.empty()) continue;
    off_m.reset();
    const auto& [begin, end] = std::pair(flown.front(), flown.back());
    const bool hung = std::hypot(begin.v_m_s[0], begin.v_m_s[1], begin.v_m_s[2]) <= kHangsStill_m_s;
    if (!hung && !stage.on_wing) continue;
    const Pose& from = stage.on_wing ? truth.front().pose : begin.pose;
    off_m = std::hypot(end.pose.x_m - from.x_m, end.pose.y_m - from.y_m);
  }
  return off_m;
}

std::optional<double> beacon_error_m(const std::vector<PluginFigure>& figures) {
  for (const PluginFigure& figure : figures) {
    if (figure.plugin == "landing_target" && figure.name == "distance from the beacon") {
      return figure.last;
    }
  }
  return std::nullopt;
}

std::optional<double> sticks_way_m(const std::vector<Stage>& stages,
                                   std::span<const PoseSample> truth) {
  std::optional<double> way_m;
  for (const Stage& stage : stages) {
    const auto flown = flown_in(stage, truth);
    if (stage.step.kind != StepKind::kSticks || flown.empty()) continue;
    const Pose& from = flown.front().pose;
    const Pose& to = flown.back().pose;
    way_m = std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
  }
  return way_m;
}

}  // namespace cas::hils
