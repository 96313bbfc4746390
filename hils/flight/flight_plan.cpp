// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/flight_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
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
/// At the end of a mission it has stayed this near to the last item and as slow for this long. An
/// autopilot takes an item for reached within an acceptance radius (PX4's NAV_ACC_RAD of
/// multicopters: 2 m), may hover there, and creeps for some seconds.
constexpr double kAcceptedNearM = 4;
constexpr base::Duration kStillAtItemFor = seconds(6);
constexpr double kSlowMS = 0.4;
/// A vehicle on its wing has taken off this far below its height: it goes on to a circle there.
constexpr double kClimbed_m = 2;
/// A vehicle flies on its circle when its estimate has stayed near the circle, and near its height,
/// for this long.
constexpr double kOnCircleHeight_m = 3;
constexpr base::Duration kOnCircleFor = seconds(10);
constexpr base::Duration kStillFor = seconds(1);
/// A landing by position is this near: drift of a stock estimator, and half a vehicle.
constexpr double kLandedNearM = 2;
/// A vehicle that is to stay above its home has begun to return after this long.
constexpr base::Duration kReturnBegins = seconds(5);

/// "step 6, 'corner3' (goto)"; the end of a trajectory, which no scenario names, has its number.
std::string words_for(std::size_t index, const std::vector<FlightStep>& steps) {
  const FlightStep& step = steps[index];
  const auto behind = std::ranges::count_if(
      steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(index) + 1,
      [](const FlightStep& each) { return each.kind != StepKind::kEndTrajectory; });
  const std::string name = step.name.empty() ? "" : ", '" + step.name + "'";
  return fmt::format("step {}{} ({})", behind, name, to_string(step.kind));
}

/// Whether a step ends what the vehicle flew about before it.
bool leaves_place(StepKind kind) {
  return is_command(kind) && kind != StepKind::kSetGain && kind != StepKind::kSetParam;
}

/// "; it said 'No offboard signal'"
std::string said(const VehicleReport& vehicle) {
  return vehicle.warning.empty() ? "" : "; it said '" + vehicle.warning + "'";
}

double tilt_deg(const VehicleReport& vehicle) {
  const double upright = std::cos(vehicle.roll_rad) * std::cos(vehicle.pitch_rad);
  return std::acos(std::clamp(upright, -1.0, 1.0)) * 180 / std::numbers::pi;
}

/// "6.0 m/s, tilted by 45 deg"
std::string motion_of(const VehicleReport& vehicle) {
  return fmt::format("{:.1f} m/s, tilted by {:.0f} deg", vehicle.v_N.norm(), tilt_deg(vehicle));
}

/// For a step that ends with a vehicle that hangs still: when its time is up, the vehicle may just
/// be near and slow.
std::string restless(double near_m, base::Duration still_for) {
  return fmt::format("; it never stayed within {} m and slower than {} m/s for {:g} s", near_m,
                     kSlowMS, base::to_seconds(still_for));
}

/// Whether takeoff, goto or rtl ends when the vehicle hangs still; else on the ground, or at a
/// height on the wing.
bool ends_still(const FlightStep& step, const VehicleReport& vehicle) {
  if (step.kind == StepKind::kRtl) return step.ends_holding;
  return step.kind == StepKind::kGoto || !vehicle.on_wing();
}

/// What the vehicle's estimate lacks for the end of a step that it has begun; empty where the step
/// says no more than its name.
/// @param reference_m  where it should be: north, east, up from the place of arming
std::string lack(const FlightStep& step, const VehicleReport& vehicle,
                 const Eigen::Vector3d& reference_m) {
  const Eigen::Vector3d p_m = vehicle.estimate().p_m + Eigen::Vector3d::Zero();  // no -0
  const Eigen::Vector3d off_m = p_m - reference_m;
  switch (step.kind) {
    case StepKind::kArm:
      return "it does not say that it is armed";
    case StepKind::kTakeoff:
    case StepKind::kGoto:
    case StepKind::kRtl:
      if (!vehicle.has_position) return "it has no position";
      if (!vehicle.in_air && step.kind != StepKind::kRtl) {
        return fmt::format("it does not say that it is in the air; {:.1f} m high", p_m.z());
      }
      return fmt::format("{:.1f} m of {:.1f} m high, {:.1f} m aside, {}{}", p_m.z(),
                         reference_m.z(), off_m.head<2>().norm(), motion_of(vehicle),
                         ends_still(step, vehicle) ? restless(kNearM, kStillFor) : "");
    case StepKind::kLand:
      return fmt::format("it does not say that it is on the ground; {:.1f} m high, {:.1f} m/s",
                         p_m.z(), vehicle.v_N.norm());
    case StepKind::kWaitUntil:
      return fmt::format("its condition did not hold; {:.1f} m north, {:.1f} m east, {:.1f} m high",
                         p_m.x(), p_m.y(), p_m.z());
    case StepKind::kLoiter:
      return fmt::format("{:.1f} m from the middle of its circle, {:.1f} m of {:.1f} m high",
                         off_m.head<2>().norm(), p_m.z(), reference_m.z());
    case StepKind::kTransition:
      return fmt::format("it says that it flies as '{}'", vehicle.vtol);
    case StepKind::kMission:
      return fmt::format("{:.1f} m from its end, {}{}", off_m.norm(), motion_of(vehicle),
                         lands(step) ? "" : restless(kAcceptedNearM, kStillAtItemFor));
    case StepKind::kDisarm:
      return "it does not say that it is disarmed";
    default:
      return "";
  }
}

}  // namespace

Motion VehicleReport::estimate() const {
  return {.p_m = {p_N.x(), p_N.y(), -p_N.z()},
          .v_m_s = {v_N.x(), v_N.y(), -v_N.z()},
          .rpy_rad = {roll_rad, pitch_rad, yaw_rad}};
}

FlightPlan::FlightPlan(std::vector<FlightStep> steps, double start_yaw_rad, FirmwareHabits habits)
    : steps_(std::move(steps)), habits_(habits), reference_yaw_rad_(start_yaw_rad) {}

VehicleReport FlightPlan::from_arming(VehicleReport vehicle) {
  if (!vehicle.heard) return vehicle;
  const FlightStep* step = current();
  if (step != nullptr && step->kind == StepKind::kArm) armed_at_N_ = vehicle.p_N;
  vehicle.p_N -= armed_at_N_;
  return vehicle;
}

FlightStep FlightPlan::in_vehicles_frame(FlightStep step) const {
  if (step.kind == StepKind::kGoto || step.kind == StepKind::kLoiter) {
    step.place_m += Eigen::Vector3d(armed_at_N_.x(), armed_at_N_.y(), -armed_at_N_.z());
  }
  return step;
}

std::optional<FlightStep> FlightPlan::update(base::SimTime now, const VehicleReport& vehicle,
                                             std::size_t others_through) {
  while (!done() && !failure_) {
    const FlightStep& step = steps_[current_];
    if (vehicle.heard) on_wing_ = vehicle.on_wing();
    if (!begun_ && others_through >= current_) begin_step(now, step);
    // A takeoff that was accepted has begun once the vehicle does not say that it is on the ground.
    if (takeoff_accepted_ && vehicle.heard && !vehicle.on_ground) lifted_off_ = true;
    const bool disarmed = begun_ && lost_its_arming(step, now, vehicle);
    if (disarmed && !lifted_off_ && !airborne_) {
      disarmed_before_takeoff_ = true;
      failure_ = "the vehicle was disarmed before it took off, during " +
                 words_for(current_, steps_) +
                 (last_refusal_.empty() ? "" : ", which it had refused: " + last_refusal_);
      break;
    }
    if (begun_ && phase_ == Phase::kBegin && vehicle.heard && now >= retry_at_ &&
        !bides(step, now, vehicle)) {
      if (needs_command(step, vehicle)) {
        phase_ = Phase::kCommanding;
        return in_vehicles_frame(step);
      }
      phase_ = Phase::kWaiting;
    }
    const bool stopped = step.kind == StepKind::kMission && !lands(step) && !vehicle.armed;
    const bool cut = (disarmed && !lands(step)) || stopped;
    const bool fell = (airborne_ && !vehicle.armed) || (cut && lifted_off_);
    if (fell && vehicle.heard) {
      failure_ = "the vehicle was disarmed during " + words_for(current_, steps_);
      break;
    }
    if (!begun_) break;
    if (phase_ == Phase::kWaiting && reached(step, now, vehicle, others_through)) {
      end_step(now);
      continue;
    }
    check_mode(step, now, vehicle);
    check_time(step, now, vehicle);
    break;
  }
  return std::nullopt;
}

base::SimTime FlightPlan::next_look(base::SimTime now) const {
  const std::optional<base::SimTime> next = only_time_until();
  if (!next || *next <= now) return now + kLookPeriod;
  return std::min(*next, now + kLongestLook);
}

/// Until when nothing that the vehicle does takes the step further: the end of one that only takes
/// its time, or the moment at which a refused command is given again.
std::optional<base::SimTime> FlightPlan::only_time_until() const {
  if (done() || !begun_) return std::nullopt;
  if (phase_ == Phase::kBegin) return retry_at_;
  if (phase_ != Phase::kWaiting) return std::nullopt;
  const FlightStep& step = steps_[current_];
  if (step.kind == StepKind::kHold) return step_begin_ + step.duration;
  if (step.kind == StepKind::kTrajectory || step.kind == StepKind::kSticks) {
    return accepted_ + step.duration;
  }
  return std::nullopt;
}

/// A step that only takes its time, or that others do, has none to be done within.
void FlightPlan::check_time(const FlightStep& step, base::SimTime now,
                            const VehicleReport& vehicle) {
  const bool timed = step.kind == StepKind::kHold || step.kind == StepKind::kTrajectory ||
                     step.kind == StepKind::kSticks || step.kind == StepKind::kStandBy;
  const bool flying_it = timed && phase_ == Phase::kWaiting;
  if (phase_ == Phase::kCommanding || flying_it || now - step_begin_ <= step.timeout) return;
  if (failure_) return;
  std::string why =
      fmt::format("{}{} was not done within {} s", words_for(current_, steps_),
                  step.name.empty() ? "" : ",", static_cast<int>(base::to_seconds(step.timeout)));
  if (!vehicle.heard) why += ": the vehicle was not heard";
  if (!last_refusal_.empty()) why += ": " + last_refusal_;
  if (last_refusal_.empty()) {
    const bool begun = vehicle.heard && phase_ == Phase::kWaiting;
    const std::string what = begun ? lack(step, vehicle, reference_m_) : "";
    if (!what.empty()) why += ": " + what;
    if (habits_.flies_setpoints) why += said(vehicle);
  }
  failure_ = std::move(why);
}

/// The modes in which a stock autopilot flies a step; none where any will do.
std::vector<std::string_view> FlightPlan::modes_of(const FlightStep& step,
                                                   const VehicleReport& vehicle) const {
  const bool px4 = vehicle.autopilot == "PX4";
  if (step.kind == StepKind::kTrajectory && habits_.flies_setpoints) {
    return {px4 ? "OFFBOARD" : "GUIDED"};
  }
  if (step.kind == StepKind::kSticks) {
    return {vehicle.autopilot == "ArduPilot" ? "LOITER" : "POSCTL"};
  }
  if (step.kind == StepKind::kRtl) return {"RTL", "LAND"};
  if (step.kind == StepKind::kBreach && step.fence) {
    // PX4 v1.14 and later hold for COM_FAIL_ACT_T before they return or land.
    return {px4 ? "OFFBOARD" : "AUTO", fence_mode(vehicle.autopilot, *step.fence), "HOLD"};
  }
  if (step.kind != StepKind::kMission) return {};
  const std::string_view mission = px4 ? "MISSION" : "AUTO";
  if (!is_at_last_item(vehicle)) return {mission};
  if (!lands(step)) return {};  // PX4 goes into HOLD at the end
  return {mission, "RTL", "LAND"};
}

/// An autopilot that leaves the mode of a step flies something else: a failsafe, a fence, another
/// operator.
void FlightPlan::check_mode(const FlightStep& step, base::SimTime now,
                            const VehicleReport& vehicle) {
  const bool flown = phase_ == Phase::kWaiting && vehicle.heard && vehicle.armed;
  if (!flown || vehicle.on_ground || vehicle.mode.empty()) return;
  const auto modes = modes_of(step, vehicle);
  if (modes.empty()) return;
  if (std::ranges::find(modes, vehicle.mode) != modes.end()) {
    mode_seen_ |= step.kind != StepKind::kBreach || vehicle.mode == modes.front();
  } else if (mode_seen_ || now - accepted_ > kHeartbeats) {
    failure_ = words_for(current_, steps_) + (step.name.empty() ? "" : ",") +
               " was broken off: the vehicle left " + std::string(modes.front()) + " for " +
               vehicle.mode + said(vehicle);
  }
}

void FlightPlan::on_outcome(base::SimTime now, const std::optional<Refusal>& refusal) {
  last_refusal_ = refusal ? refusal->why : std::string();
  if (!refusal) {
    phase_ = Phase::kWaiting;
    accepted_ = now;
    const StepKind kind = steps_[current_].kind;
    takeoff_accepted_ = kind == StepKind::kTakeoff || kind == StepKind::kMission;
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
               .reference_yaw_rad = reference_yaw_rad_,
               .circle_m = std::abs(circle_m_),
               .on_wing = on_wing_,
               .armed_at_N = armed_at_N_};
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
  return true;
}

/// Whether a vehicle that accepted arming is not armed any more, before or after it accepted its
/// takeoff.
bool FlightPlan::lost_its_arming(const FlightStep& step, base::SimTime now,
                                 const VehicleReport& vehicle) const {
  if (!habits_.arms_early || !vehicle.heard || vehicle.armed) return false;
  if (phase_ == Phase::kBegin) return takes_off(step);
  const bool needs_it = step.kind == StepKind::kArm || takes_off(step);
  return needs_it && phase_ == Phase::kWaiting && now - accepted_ > kHeartbeats;
}

/// Whether the step's command would come too early.
bool FlightPlan::bides(const FlightStep& step, base::SimTime now, const VehicleReport& vehicle) {
  if (!vehicle.armed) {
    if (!habits_.arms_early || step.kind != StepKind::kArm) return false;
    if (!vehicle.position_lack) return false;
    last_refusal_ = *vehicle.position_lack + said(vehicle);
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
      return vehicle.in_air && has_taken_off(now, vehicle);
    case StepKind::kGoto:
      return vehicle.in_air && hangs_still(now, vehicle);
    case StepKind::kLoiter:
      return vehicle.in_air && circles(now, vehicle);
    case StepKind::kTransition:
      return vehicle.vtol == (step.to_plane ? "plane" : "multicopter");
    case StepKind::kHold:
      return now - step_begin_ >= step.duration;
    case StepKind::kTrajectory:
    case StepKind::kSticks:
      return now - accepted_ >= step.duration;
    case StepKind::kWaitUntil:
      return condition_holds(step, now, vehicle);
    case StepKind::kEndTrajectory:
      if (step.sticks) reference_m_ = vehicle.estimate().p_m;  // wherever they have taken it
      return true;
    case StepKind::kSetGain:
    case StepKind::kSetParam:
    case StepKind::kReboot:
      return true;
    case StepKind::kMission:
      return has_flown_mission(step, now, vehicle);
    case StepKind::kBreach:
      return fence_took_over(step, vehicle);
    case StepKind::kRtl:
      return has_returned(step, now, vehicle);
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
  const bool in_mission = steps_[current_].kind == StepKind::kMission;
  const double near_m = in_mission ? kAcceptedNearM : kNearM;
  if (!stays(now, vehicle.has_position && (p_up - reference_m_).norm() < near_m &&
                      vehicle.v_N.norm() < kSlowMS)) {
    return false;
  }
  return !in_mission || now - *still_since_ >= kStillAtItemFor;
}

bool FlightPlan::has_taken_off(base::SimTime now, const VehicleReport& vehicle) {
  if (!vehicle.on_wing()) return hangs_still(now, vehicle);
  return vehicle.has_position && -vehicle.p_N.z() >= reference_m_.z() - kClimbed_m;
}

bool FlightPlan::circles(base::SimTime now, const VehicleReport& vehicle) {
  const Eigen::Vector3d from_middle_m =
      Eigen::Vector3d(vehicle.p_N.x(), vehicle.p_N.y(), -vehicle.p_N.z()) - reference_m_;
  const double radius_m = std::abs(circle_m_);
  const bool near = std::abs(from_middle_m.head<2>().norm() - radius_m) < kOnCircleShare * radius_m;
  const bool high = std::abs(from_middle_m.z()) < kOnCircleHeight_m;
  return stays(now, vehicle.has_position && near && high) && now - *still_since_ >= kOnCircleFor;
}

bool FlightPlan::stays(base::SimTime now, bool still) {
  if (!still) {
    still_since_.reset();
    return false;
  }
  if (!still_since_) still_since_ = now;
  return now - *still_since_ >= kStillFor;
}

/// On the ground at the end of the plan; elsewhere the step has failed.
bool FlightPlan::has_landed_there(const VehicleReport& vehicle) {
  if (!vehicle.on_ground) return false;
  const double off_m = (vehicle.p_N - reference_m_).head<2>().norm();
  if (off_m <= (vehicle.on_wing() ? kRunOut_m : kLandedNearM)) return true;
  failure_ = fmt::format("{} ended on the ground {} m from its place{}",
                         words_for(current_, steps_), std::lround(off_m), said(vehicle));
  return false;
}

bool FlightPlan::has_returned(const FlightStep& step, base::SimTime now,
                              const VehicleReport& vehicle) {
  if (!step.ends_holding) return has_landed_there(vehicle);
  const double off_m = (vehicle.p_N - reference_m_).head<2>().norm();
  const bool above = vehicle.has_position && vehicle.in_air && off_m < kNearM;
  return stays(now, now - accepted_ > kReturnBegins && above && vehicle.v_N.norm() < kSlowMS);
}

/// The vehicle hung in HOLD before, too: it must have flown towards the fence.
bool FlightPlan::fence_took_over(const FlightStep& step, const VehicleReport& vehicle) const {
  return mode_seen_ && step.fence && vehicle.mode == fence_mode(vehicle.autopilot, *step.fence);
}

bool FlightPlan::is_at_last_item(const VehicleReport& vehicle) const {
  return !last_item_ || (vehicle.mission_reached && *vehicle.mission_reached >= *last_item_);
}

bool FlightPlan::has_flown_mission(const FlightStep& step, base::SimTime now,
                                   const VehicleReport& vehicle) {
  if (!lifted_off_) return false;
  if (!is_at_last_item(vehicle)) {
    if (vehicle.on_ground && !vehicle.armed) {
      failure_ =
          words_for(current_, steps_) + " ended on the ground before its last item" + said(vehicle);
    }
    return false;
  }
  return lands(step) ? has_landed_there(vehicle) : hangs_still(now, vehicle);
}

void FlightPlan::aim(const HomedMission& mission) {
  reference_m_ = mission.end_m;
  last_item_ = mission.last;
  if (done()) return;
  steps_[current_].reach_m = mission.reach_m;
  steps_[current_].places = mission.places;
}

void FlightPlan::begin_step(base::SimTime now, const FlightStep& step) {
  begun_ = true;
  phase_ = Phase::kBegin;
  step_begin_ = now;
  accepted_ = now;
  retry_at_ = now;
  still_since_.reset();
  takeoff_accepted_ = lifted_off_ = mode_seen_ = false;
  last_refusal_.clear();
  if (step.kind == StepKind::kTakeoff) reference_m_ = {0, 0, step.altitude_m};
  if (step.kind == StepKind::kGoto) {
    reference_m_ = step.place_m;
    reference_yaw_rad_ = step.yaw_rad;
  }
  if (leaves_place(step.kind)) circle_m_ = step.radius_m;
  if (step.kind == StepKind::kLoiter) reference_m_ = step.place_m;
  if (step.kind == StepKind::kRtl) reference_m_ = {0, 0, step.ends_holding ? reference_m_.z() : 0};
}

void FlightPlan::end_step(base::SimTime now) {
  Stage stage = *under_way(now);
  stage.accepted = accepted_;
  stages_.push_back(std::move(stage));
  const FlightStep& step = steps_[current_];
  airborne_ = (airborne_ || takes_off(step)) && !lands(step);
  ++current_;
  if (!done() && lands(steps_[current_])) airborne_ = false;  // it may disarm now
  begun_ = false;
}

}  // namespace cas::hils
