// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/figures_so_far.hpp"

#include <algorithm>
#include <utility>

#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"

namespace cas::hils {

namespace {

/// An older estimate says where the vehicle was.
constexpr double kFresh_s = 0.3;

Pose to_pose(const Motion& motion) {
  return {.x_m = motion.p_m.x(),
          .y_m = motion.p_m.y(),
          .z_m = motion.p_m.z(),
          .roll_rad = motion.rpy_rad.x(),
          .pitch_rad = motion.rpy_rad.y(),
          .yaw_rad = motion.rpy_rad.z()};
}

/// A flight without fault, so that judge() lists every limit.
Measurement flawless(const Limits& limits) {
  Measurement figures;
  figures.virtual_clock = true;
  figures.over_hold = true;
  for (RateFigures* rate : {&figures.rates.sensor, &figures.rates.gps, &figures.rates.controls}) {
    *rate = {.sent = 1, .received = 1, .drained = true};
  }
  for (const auto& [name, limit] : limits.responses) {
    figures.responses.push_back({.name = name});
  }
  return figures;
}

}  // namespace

void FiguresSoFar::add(const Stage& stage, base::SimTime now, const VehicleReport& vehicle) {
  if (newest_ && now < *newest_) *this = {};  // the simulation restarted
  if (!stage.step.measure || newest_ == now) return;
  newest_ = now;
  const Pose reference = reference_at(stage, static_cast<std::int64_t>(base::to_time_usec(now)));
  if (vehicle.truth) truth_.add(to_pose(*vehicle.truth), reference);
  if (!vehicle.has_position || vehicle.position_age_s >= kFresh_s) return;
  if (counted_ && counted_->first == vehicle.p_N && counted_->second == vehicle.v_N) return;
  counted_ = {vehicle.p_N, vehicle.v_N};
  estimate_.add(to_pose(vehicle.estimate()), reference);
}

std::vector<LimitCheck> FiguresSoFar::checks(const Limits& limits) const {
  Measurement figures = flawless(limits);
  figures.rms = truth_.figures();
  figures.rms_estimate = estimate_.figures();
  const bool flown = figures.rms->samples > 0 && figures.rms_estimate->samples > 0;
  Verdict verdict = judge(figures, limits);
  std::erase_if(verdict.checks, [](const LimitCheck& check) {
    return check.kind == LimitCheck::Kind::kValidity || !check.bound;
  });
  for (LimitCheck& check : verdict.checks) {
    check.judged = true;
    if (flown && check.about == LimitCheck::About::kRms) continue;
    check.value.reset();
    check.found = "not known yet";
    check.kept = true;
    check.sentence.clear();
  }
  return std::move(verdict.checks);
}

std::optional<Stage> reference_stage(const FlightPlan& plan, base::SimTime now) {
  std::optional<Stage> stage = plan.under_way(now);
  if (!stage && !plan.stages().empty() && !plan.done()) stage = plan.stages().back();
  if (!stage) return std::nullopt;
  bool climbed = false;
  const auto pass = [&climbed](const Stage& each) {
    climbed |= takes_off(each.step);
    if (lands(each.step)) climbed = false;
  };
  std::ranges::for_each(plan.stages(), pass);
  pass(*stage);
  return climbed ? stage : std::nullopt;
}

}  // namespace cas::hils
