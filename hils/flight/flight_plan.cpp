// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/flight_plan.hpp"

#include <algorithm>
#include <utility>

namespace cas::hils {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A refused command is repeated at this pace: estimators need a while before they let one arm.
constexpr base::Duration kRetry = seconds(1);
/// HEARTBEATs come each second: the one that shows an accepted arming comes within this long.
constexpr base::Duration kHeartbeats = seconds(3);
/// A vehicle hangs still when it has stayed this near and this slow for this long, by its estimate.
constexpr double kNearM = 0.5;
constexpr double kSlowMS = 0.4;
constexpr base::Duration kStillFor = seconds(1);

/// "step 6, 'corner3' (goto)"; the end of a trajectory, which no scenario names, has its number.
std::string words_for(std::size_t index, const std::vector<FlightStep>& steps) {
  const FlightStep& step = steps[index];
  const auto behind = std::ranges::count_if(
      steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(index) + 1,
      [](const FlightStep& each) { return each.kind != StepKind::kEndTrajectory; });
  const std::string name = step.name.empty() ? "" : ", '" + step.name + "'";
  return "step " + std::to_string(behind) + name + " (" + std::string(to_string(step.kind)) + ")";
}

}  // namespace

Motion VehicleReport::estimate() const {
  return {.p_m = {p_N.x(), p_N.y(), -p_N.z()},
          .v_m_s = {v_N.x(), v_N.y(), -v_N.z()},
          .rpy_rad = {roll_rad, pitch_rad, yaw_rad}};
}

FlightPlan::FlightPlan(std::vector<FlightStep> steps, double start_yaw_rad, FirmwareHabits habits)
    : steps_(std::move(steps)), habits_(habits), reference_yaw_rad_(start_yaw_rad) {}

std::optional<FlightStep> FlightPlan::update(base::SimTime now, const VehicleReport& vehicle,
                                             std::size_t others_through) {
  while (!done() && failure_.empty()) {
    const FlightStep& step = steps_[current_];
    if (!begun_ && others_through >= current_) begin_step(now, step);
    // A takeoff that was accepted has begun once the vehicle does not say that it is on the ground.
    if (takeoff_accepted_ && vehicle.heard && !vehicle.on_ground) lifted_off_ = true;
    const bool disarmed = begun_ && lost_its_arming(step, now, vehicle);
    if (disarmed && !lifted_off_) phase_ = Phase::kBegin;
    if (begun_ && phase_ == Phase::kBegin && vehicle.heard && now >= retry_at_ &&
        !bides(step, now, vehicle)) {
      if (needs_command(step, vehicle)) {
        phase_ = Phase::kCommanding;
        rearming_ = habits_.arms_early && step.kind == StepKind::kTakeoff && !vehicle.armed;
        return rearming_ ? FlightStep{.kind = StepKind::kArm} : step;
      }
      phase_ = Phase::kWaiting;
    }
    if ((airborne_ && !vehicle.armed && vehicle.heard) || (disarmed && lifted_off_)) {
      failure_ = std::string(kDisarmedDuring) + words_for(current_, steps_);
      break;
    }
    if (!begun_) break;
    if (phase_ == Phase::kWaiting && reached(step, now, vehicle, others_through)) {
      end_step(now);
      continue;
    }
    check_time(step, now, vehicle);
    break;
  }
  return std::nullopt;
}

/// A step that only takes its time, or that others do, has none to be done within.
void FlightPlan::check_time(const FlightStep& step, base::SimTime now,
                            const VehicleReport& vehicle) {
  const bool timed = step.kind == StepKind::kHold || step.kind == StepKind::kTrajectory ||
                     step.kind == StepKind::kStandBy;
  const bool flying_it = timed && phase_ == Phase::kWaiting;
  if (phase_ == Phase::kCommanding || flying_it || now - step_begin_ <= step.timeout) return;
  failure_ = words_for(current_, steps_) + (step.name.empty() ? "" : ",") +
             " was not done within " +
             std::to_string(static_cast<int>(base::to_seconds(step.timeout))) + " s";
  if (!vehicle.heard) failure_ += ": the vehicle was not heard";
  if (!last_refusal_.empty()) failure_ += ": " + last_refusal_;
}

void FlightPlan::on_outcome(base::SimTime now, const std::string& refusal) {
  last_refusal_ = refusal;
  const bool again = std::exchange(rearming_, false);
  if (again && refusal.empty()) armed_again_ = now;
  if (refusal.empty() && !again) {
    phase_ = Phase::kWaiting;
    accepted_ = now;
    takeoff_accepted_ = steps_[current_].kind == StepKind::kTakeoff;
    return;
  }
  phase_ = Phase::kBegin;
  retry_at_ = now + kRetry;
}

std::string_view FlightPlan::phase() const {
  if (done()) return "done";
  return begun_ || current_ > 0 ? phase_of(steps_[current_]) : std::string_view();
}

std::optional<Stage> FlightPlan::under_way(base::SimTime now) const {
  if (done() || !begun_) return std::nullopt;
  return Stage{.step = steps_[current_],
               .begin = step_begin_,
               .end = now,
               .accepted = phase_ == Phase::kWaiting ? accepted_ : now,
               .reference_m = reference_m_,
               .reference_yaw_rad = reference_yaw_rad_};
}

std::optional<Stage> FlightPlan::measured() const {
  for (const Stage& stage : stages_) {
    if (stage.step.measure) return stage;
  }
  return std::nullopt;
}

bool FlightPlan::needs_command(const FlightStep& step, const VehicleReport& vehicle) const {
  if (!is_command(step.kind)) return false;
  if (step.kind == StepKind::kDisarm) return vehicle.armed;
  // Armed again in its takeoff mode, it takes off by itself.
  if (step.kind == StepKind::kTakeoff) return !lifted_off_;
  return true;
}

/// Whether a vehicle that accepted arming, or armed the takeoff, is not armed any more.
bool FlightPlan::lost_its_arming(const FlightStep& step, base::SimTime now,
                                 const VehicleReport& vehicle) const {
  const bool needs_it = step.kind == StepKind::kArm || step.kind == StepKind::kTakeoff;
  return habits_.arms_early && needs_it && phase_ == Phase::kWaiting && vehicle.heard &&
         !vehicle.armed && now - accepted_ > kHeartbeats;
}

/// Whether the step's command would come too early.
bool FlightPlan::bides(const FlightStep& step, base::SimTime now, const VehicleReport& vehicle) {
  if (!vehicle.armed) {
    const bool arms = step.kind == StepKind::kArm || step.kind == StepKind::kTakeoff;
    if (!habits_.arms_early || !arms) return false;
    if (armed_again_ && now - *armed_again_ <= kHeartbeats) return true;
    if (vehicle.position_lack.empty()) return false;
    last_refusal_ = vehicle.position_lack;
    return true;
  }
  return step.kind == StepKind::kDisarm &&
         now - step_begin_ < std::min(habits_.disarms_itself, step.timeout / 2);
}

bool FlightPlan::reached(const FlightStep& step, base::SimTime now, const VehicleReport& vehicle,
                         std::size_t others_through) {
  switch (step.kind) {
    case StepKind::kArm:
      return vehicle.armed;
    case StepKind::kTakeoff:
    case StepKind::kGoto:
      return vehicle.in_air && hangs_still(now, vehicle);
    case StepKind::kHold:
      return now - step_begin_ >= step.duration;
    case StepKind::kTrajectory:
      return now - accepted_ >= step.duration;
    case StepKind::kWaitUntil:
      return condition_holds(step, now, vehicle);
    case StepKind::kEndTrajectory:
    case StepKind::kSetGain:
    case StepKind::kSetParam:
      return true;
    case StepKind::kLand:
      return vehicle.on_ground;
    case StepKind::kDisarm:
      return !vehicle.armed;
    case StepKind::kStandBy:
      return others_through > current_;
  }
  return false;
}

bool FlightPlan::condition_holds(const FlightStep& step, base::SimTime now,
                                 const VehicleReport& vehicle) const {
  if (step.until->on_truth && !vehicle.truth) return false;
  const Motion motion = step.until->on_truth ? *vehicle.truth : vehicle.estimate();
  return step.until->expression.evaluate(facts_of(now, motion, vehicle.armed, phase_of(step)));
}

bool FlightPlan::hangs_still(base::SimTime now, const VehicleReport& vehicle) {
  const Eigen::Vector3d p_up(vehicle.p_N.x(), vehicle.p_N.y(), -vehicle.p_N.z());
  const bool still =
      vehicle.has_position && (p_up - reference_m_).norm() < kNearM && vehicle.v_N.norm() < kSlowMS;
  if (!still) {
    still_since_.reset();
    return false;
  }
  if (!still_since_) still_since_ = now;
  return now - *still_since_ >= kStillFor;
}

void FlightPlan::begin_step(base::SimTime now, const FlightStep& step) {
  begun_ = true;
  phase_ = Phase::kBegin;
  step_begin_ = now;
  accepted_ = now;
  retry_at_ = now;
  still_since_.reset();
  takeoff_accepted_ = lifted_off_ = false;
  last_refusal_.clear();
  if (step.kind == StepKind::kTakeoff) reference_m_ = {0, 0, step.altitude_m};
  if (step.kind == StepKind::kGoto) {
    reference_m_ = step.place_m;
    reference_yaw_rad_ = step.yaw_rad;
  }
}

void FlightPlan::end_step(base::SimTime now) {
  Stage stage = *under_way(now);
  stage.accepted = accepted_;
  stages_.push_back(std::move(stage));
  if (steps_[current_].kind == StepKind::kTakeoff) airborne_ = true;
  ++current_;
  if (!done() && steps_[current_].kind == StepKind::kLand) airborne_ = false;  // it may disarm now
  begun_ = false;
}

}  // namespace cas::hils
