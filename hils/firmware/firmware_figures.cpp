// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "hils/firmware/true_steps.hpp"
#include "hils/measure/record_hole.hpp"
#include "mavlink_gen/runtime/sha256.hpp"

namespace cas::hils {
namespace {

using nlohmann::json;

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

/// A hold is measured about its mean: where a stock estimator's origin lies is not known so well.
/// @param start  of the record
void measure_hold(const Stage& hold, const Pose& start, std::span<const PoseSample> held,
                  FirmwareFigures& figures) {
  const Pose mean = mean_of(held);
  const ReferenceAt about_mean = [&mean](std::int64_t) { return mean; };
  figures.rms = rms_about(held, about_mean);
  figures.peak_error_m = peak_error_m(held, about_mean);
  figures.height_error_m = std::abs(mean.z_m - start.z_m - hold.reference_m.z());
  const Pose& begin = held.front().pose;
  double drift_m = 0;
  for (const PoseSample& sample : held) {
    drift_m =
        std::max(drift_m, std::hypot(sample.pose.x_m - begin.x_m, sample.pose.y_m - begin.y_m));
  }
  figures.drift_m = drift_m;
}

/// Of the measured step, if the flight has come through it.
void measure_step(std::span<const PoseSample> truth, FirmwareFigures& figures) {
  const auto stage =
      std::ranges::find_if(figures.stages, [](const Stage& each) { return each.step.measure; });
  if (stage == figures.stages.end()) return;
  const auto flown = between(truth, to_microseconds(stage->begin), to_microseconds(stage->end));
  if (flown.empty()) return;
  figures.rotor_activity_rad_s2 = rotor_activity_rad_s2(flown);
  if (stage->step.kind != StepKind::kTrajectory) {
    return measure_hold(*stage, truth.front().pose, flown, figures);
  }
  const ReferenceAt reference = reference_in_truth(*stage, truth);
  figures.rms = rms_about(flown, reference);
  figures.peak_error_m = peak_error_m(flown, reference);
}

}  // namespace

ParamDigest digest_of(const json& list) {
  std::map<std::string, std::string> values;
  for (const json& param : list) {
    values[param.value("name", "")] = param.value("value", json()).dump();
  }
  mav::Sha256 hash;
  for (const auto& [name, value] : values) {
    const std::string line = name + " " + value + "\n";
    hash.update({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
  }
  ParamDigest digest{.count = values.size()};
  for (const std::uint8_t byte : hash.finish()) digest.sha256 += fmt::format("{:02x}", byte);
  return digest;
}

std::vector<Stage> FirmwareFigures::flown_stages() const {
  std::vector<Stage> flown = stages;
  if (under_way) flown.push_back(*under_way);
  return flown;
}

Measurement FirmwareFigures::motion() const {
  Measurement figures;
  figures.rms = rms;
  figures.rms_estimate = rms_estimate;
  figures.peak_error_m = peak_error_m;
  figures.rotor_activity_rad_s2 = rotor_activity_rad_s2;
  return figures;
}

std::string_view measured_about(const std::vector<Stage>& stages) {
  const auto step = std::ranges::find_if(stages, [](const Stage& s) { return s.step.measure; });
  const bool moves = step != stages.end() && step->step.kind == StepKind::kTrajectory;
  return moves ? "the reference" : "its mean";
}

void add_truth(const std::filesystem::path& truth, FirmwareFigures& figures) {
  try {
    const std::vector<PoseSample> samples = read_truth(truth);
    if (samples.empty()) {
      figures.unwatched = truth.string() + " is empty";
    } else {
      const std::vector<Stage> flown = figures.flown_stages();
      if (const auto hole = record_hole(flown, samples)) {
        figures.unwatched = truth.string() + ": " + *hole;
      }
      figures.incidents = find_incidents(flown, samples);
      figures.not_flown = steps_not_flown(figures.stages, samples);
      measure_step(samples, figures);
      if (figures.fence) add_reach(samples, *figures.fence);
    }
  } catch (const base::ConfigError& error) {
    figures.unwatched = error.what();
  }
}

void add_estimate(const std::filesystem::path& truth, const std::filesystem::path& tlog,
                  FirmwareFigures& figures) {
  try {
    const std::vector<PoseSample> estimate = read_estimate(tlog, figures.system, figures.log_clock);
    figures.rms_estimate = estimate_error(figures.stages, read_truth(truth), estimate);
  } catch (const base::ConfigError&) {
    figures.rms_estimate.reset();  // a limit on it is missed
  }
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

std::optional<double> slowest_hop_us(const json& hops) {
  std::optional<double> slowest;
  for (const json& link : hops) {
    for (const json& route : link.value("routes", json::array())) {
      slowest = std::max(slowest.value_or(0), route.value("p99", 0.0));
    }
  }
  return slowest;
}

void add_losses(const json& links, FirmwareFigures& figures) {
  for (const json& link : links) {
    for (const json& count : link.at("tx").at("dropped")) {
      figures.dropped += count.get<std::uint64_t>();
    }
    figures.lost += link.at("rx").at("lost").get<std::uint64_t>();
  }
}

}  // namespace cas::hils
