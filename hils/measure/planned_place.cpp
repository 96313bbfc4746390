// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/planned_place.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/time/clock.hpp"

namespace cas::hils {

namespace {

bool is_pattern(const Stage& stage) {
  return stage.step.kind == StepKind::kTrajectory || stage.step.kind == StepKind::kEndTrajectory ||
         stage.circle_m > 0;
}

}  // namespace

bool keeps_place(const Stage& stage) {
  return stage.step.kind == StepKind::kHold || stage.step.kind == StepKind::kWaitUntil;
}

PlannedPath::PlannedPath(std::span<const FlightStep> steps) {
  for (const FlightStep& step : steps) {
    if (step.kind == StepKind::kTakeoff) places_.emplace_back(0, 0, step.altitude_m);
    if (step.kind == StepKind::kGoto || step.kind == StepKind::kLoiter) {
      places_.push_back(step.place_m);
    }
    slack_m_ = std::max(slack_m_, std::abs(step.radius_m));
    if (step.kind == StepKind::kTrajectory) slack_m_ = std::max(slack_m_, step.trajectory.size_m);
    if (step.kind == StepKind::kRtl) places_.emplace_back(0, 0, places_.back().z());
    if (lands(step)) {
      places_.emplace_back(places_.back().x(), places_.back().y(), 0);
    }
  }
}

double PlannedPath::distance_m(const Eigen::Vector3d& p) const {
  double least = (p - places_.front()).norm();
  for (std::size_t i = 1; i < places_.size(); ++i) {
    const Eigen::Vector3d along = places_[i] - places_[i - 1];
    const double length2 = along.squaredNorm();
    const double share =
        length2 > 0 ? std::clamp((p - places_[i - 1]).dot(along) / length2, 0.0, 1.0) : 0.0;
    least = std::min(least, (p - places_[i - 1] - share * along).norm());
  }
  return least;
}

double PlannedPlace::distance_m(std::int64_t time_us, const Eigen::Vector3d& p) const {
  const auto next = std::ranges::upper_bound(stages_, time_us, {}, [](const Stage& stage) {
    return static_cast<std::int64_t>(base::to_time_usec(stage.begin));
  });
  if (next == stages_.begin()) return path_.distance_m(p);
  const auto stage = std::prev(next);
  const bool at_place = keeps_place(*stage) && !landed_before(next);
  const double off_m = at_place ? (p - stage->reference_m).norm() : path_.distance_m(p);
  const bool flies_pattern =
      is_pattern(*stage) || (stage != stages_.begin() && is_pattern(*std::prev(stage)));
  return flies_pattern ? std::max(0.0, off_m - path_.slack_m()) : off_m;
}

/// After a landing a hold still has the reference of the flight before.
bool PlannedPlace::landed_before(std::span<const Stage>::iterator end) const {
  bool landed = false;
  for (auto each = stages_.begin(); each != end; ++each) {
    if (lands(each->step)) landed = true;
    if (takes_off(each->step)) landed = false;
  }
  return landed;
}

}  // namespace cas::hils
