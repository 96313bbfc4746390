// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/step_response.hpp"

#include <algorithm>
#include <cmath>

namespace cas::hils {

namespace {

constexpr double kRiseBegin = 0.1;
constexpr double kRiseEnd = 0.9;
constexpr double kSettledBand = 0.05;

/// First moment at which the share of the step is reached.
std::optional<double> reached_s(std::span<const ResponseSample> samples, double from, double size,
                                double share) {
  for (const ResponseSample& sample : samples) {
    if ((sample.value - from) / size >= share) return sample.time_s;
  }
  return std::nullopt;
}

/// Moment after the last sample outside of the band; nullopt when that is the last of all.
std::optional<double> settled_s(std::span<const ResponseSample> samples, double to, double band) {
  std::size_t first_inside = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::abs(samples[i].value - to) > band) first_inside = i + 1;
  }
  if (first_inside >= samples.size()) return std::nullopt;
  return samples[first_inside].time_s;
}

}  // namespace

StepResponse respond(std::span<const ResponseSample> samples, double step_s, double from,
                     double to) {
  const auto first = std::ranges::lower_bound(samples, step_s, {}, &ResponseSample::time_s);
  samples = samples.subspan(static_cast<std::size_t>(first - samples.begin()));
  StepResponse response{.size = to - from};
  const double size = to - from;
  if (size == 0 || samples.empty()) return response;
  const auto begin = reached_s(samples, from, size, kRiseBegin);
  const auto end = reached_s(samples, from, size, kRiseEnd);
  if (begin && end) response.rise_s = *end - *begin;
  if (const auto settled = settled_s(samples, to, kSettledBand * std::abs(size))) {
    response.settling_s = *settled - step_s;
  }
  double most = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    most = std::max(most, (samples[i].value - to) / size);
    if (i == 0) continue;
    const double dt = samples[i].time_s - samples[i - 1].time_s;
    response.integrated_error += std::abs(samples[i].value - to) * dt;
  }
  response.overshoot_pct = 100 * most;
  return response;
}

std::vector<StepResponse> step_responses(const std::vector<Stage>& stages,
                                         std::span<const PoseSample> truth) {
  std::vector<StepResponse> responses;
  if (truth.empty()) return responses;
  const double start_m = truth.front().pose.x_m;
  for (const Stage& stage : stages) {
    const Trajectory& trajectory = stage.step.trajectory;
    if (stage.step.kind != StepKind::kTrajectory || trajectory.shape != fcu::PatternShape::kSteps) {
      continue;
    }
    const auto in_stage =
        between(truth, static_cast<std::int64_t>(base::to_time_usec(stage.accepted)),
                static_cast<std::int64_t>(base::to_time_usec(stage.end)));
    std::vector<ResponseSample> samples;
    for (const PoseSample& sample : in_stage) {
      samples.push_back({1e-6 * static_cast<double>(sample.time_us), sample.pose.x_m - start_m});
    }
    const double from = stage.reference_m.x();
    responses.push_back(respond(samples, base::to_seconds(stage.accepted) + trajectory.period_s,
                                from, from + trajectory.size_m));
    responses.back().name = phase_of(stage.step);
  }
  return responses;
}

}  // namespace cas::hils
