// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/hold_motion.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "hils/measure/step_figures.hpp"

namespace cas::hils {
namespace {

/// The mean place and heading.
Pose mean_of(std::span<const PoseSample> samples) {
  Pose mean;
  double sines = 0;
  double cosines = 0;
  const auto count = static_cast<double>(samples.size());
  for (const PoseSample& sample : samples) {
    mean.x_m += sample.pose.x_m / count;
    mean.y_m += sample.pose.y_m / count;
    mean.z_m += sample.pose.z_m / count;
    sines += std::sin(sample.pose.yaw_rad);
    cosines += std::cos(sample.pose.yaw_rad);
  }
  mean.yaw_rad = std::atan2(sines, cosines);
  return mean;
}

bool moves(const Stage& stage) { return stage.step.kind == StepKind::kTrajectory; }

bool circles(const Stage& stage) { return !moves(stage) && stage.circle_m > 0; }

/// The estimate of our controller, whose origin is known.
std::optional<RmsFigures> error_from_reference(const Stage& stage,
                                               std::span<const PoseSample> estimate) {
  const auto flown = between(estimate, to_microseconds(stage.begin), to_microseconds(stage.end));
  if (flown.empty()) return std::nullopt;
  return rms_about(
      flown, [&stage](std::int64_t time_us) { return reference_in_estimate(stage, time_us); });
}

}  // namespace

const Stage* measured_stage(const std::vector<Stage>& stages) {
  const auto stage = std::ranges::find_if(stages, [](const Stage& s) { return s.step.measure; });
  return stage == stages.end() ? nullptr : &*stage;
}

std::string_view measured_about(const Measurement& figures) {
  const Stage* const stage = measured_stage(figures.stages);
  if (stage != nullptr && circles(*stage)) return "its circle";
  return figures.firmware && stage != nullptr && !moves(*stage) ? "its mean" : "the reference";
}

void measure_motion(const RunRecord& record, std::span<const PoseSample> truth,
                    Measurement& figures) {
  const Stage& stage = *record.hold;
  const auto flown = between(truth, to_microseconds(stage.begin), to_microseconds(stage.end));
  if (!flown.empty()) {
    const Pose mean = mean_of(flown);
    const bool about_mean = record.firmware && !moves(stage) && !circles(stage);
    const ReferenceAt reference = about_mean ? ReferenceAt([&mean](std::int64_t) { return mean; })
                                  : circles(stage) ? circle_reference(stage, truth)
                                                   : reference_in_truth(stage, truth);
    figures.least_airspeed_m_s = least_airspeed_m_s(flown);
    figures.rms = rms_about(flown, reference);
    figures.peak_error_m = peak_error_m(flown, reference);
    figures.rotor_activity_rad_s2 = rotor_activity_rad_s2(flown);
    if (!moves(stage)) {
      figures.height_error_m = height_error_m(flown, reference_in_truth(stage, truth));
    }
    if (circles(stage)) {
      // A circle asks for no heading.
      if (figures.rms) figures.rms->yaw_rad = std::numeric_limits<double>::quiet_NaN();
      figures.radius_error_pct = radius_error_pct(stage, flown, truth.front().pose);
    } else if (!moves(stage)) {
      figures.drift_m = drift_m(flown);
    }
  }
  const std::vector<PoseSample>& estimate = record.estimate();
  // A circle of ours is not where the estimate was to be at a moment, so the truth is its measure.
  figures.rms_estimate = record.firmware || circles(stage)
                             ? estimate_error(record.stages, truth, estimate)
                             : error_from_reference(stage, estimate);
}

std::optional<RmsFigures> estimate_error(const std::vector<Stage>& stages,
                                         std::span<const PoseSample> truth,
                                         std::span<const PoseSample> estimate) {
  const auto takeoff =
      std::ranges::find_if(stages, [](const Stage& stage) { return takes_off(stage.step); });
  const auto hold = std::ranges::find_if(stages, [](const Stage& s) { return s.step.measure; });
  if (takeoff == stages.end() || hold == stages.end() || truth.empty()) return std::nullopt;
  const auto true_at = [truth](std::int64_t time_us) {
    const auto next = std::ranges::lower_bound(truth, time_us, {}, &PoseSample::time_us);
    return next == truth.end() ? truth.back().pose : next->pose;
  };
  const std::int64_t off_us = to_microseconds(takeoff->begin);
  const auto standing = between(estimate, off_us - 1'000'000, off_us);
  const auto held = between(estimate, to_microseconds(hold->begin), to_microseconds(hold->end));
  if (standing.empty() || held.empty()) return std::nullopt;
  Pose origin;
  const auto count = static_cast<double>(standing.size());
  for (const PoseSample& sample : standing) {
    const Pose pose = true_at(sample.time_us);
    origin.x_m += (sample.pose.x_m - pose.x_m) / count;
    origin.y_m += (sample.pose.y_m - pose.y_m) / count;
    origin.z_m += (sample.pose.z_m - pose.z_m) / count;
  }
  return rms_about(held, [&](std::int64_t time_us) {
    Pose pose = true_at(time_us);
    pose.x_m += origin.x_m;
    pose.y_m += origin.y_m;
    pose.z_m += origin.z_m;
    return pose;
  });
}

std::optional<StreamWindow> machine_window(const RunRecord& record,
                                           const std::vector<Incident>& incidents) {
  constexpr base::Duration kLeast = std::chrono::seconds(1);
  const std::vector<Stage> flown = record.flown_stages();
  if (flown.empty()) return std::nullopt;
  base::SimTime begin = flown.front().begin;
  base::SimTime end = flown.back().end;
  const Stage* const measured = measured_stage(record.stages);
  if (!record.flight_failure && incidents.empty() && measured != nullptr) {
    begin = measured->begin;
    end = measured->end;
  }
  for (const BenchFaultScript::Span& fault : record.firmware->bench_faults) {
    end = std::min(end, fault.begin);
  }
  if (record.firmware->fell_silent) end = std::min(end, *record.firmware->fell_silent);
  if (end - begin < kLeast) begin = flown.front().begin;
  if (end - begin < kLeast) return std::nullopt;
  return StreamWindow{base::to_time_usec(begin), base::to_time_usec(end)};
}

}  // namespace cas::hils
