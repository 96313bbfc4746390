// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/strike_response.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/measure/incident.hpp"
#include "hils/measure/run_record.hpp"
#include "plugins/fault/fault_spec.hpp"

namespace cas::hils {

namespace {

/// The lines between the places of a plan, from the start to the landing; north, east, up from the
/// start, m.
class PlannedPath {
 public:
  explicit PlannedPath(std::span<const FlightStep> steps);

  /// Distance of a point from the nearest line.
  double distance_m(const Eigen::Vector3d& p) const;
  /// Largest size of a trajectory: so far may a vehicle leave the lines while it flies one.
  double slack_m() const { return slack_m_; }

 private:
  std::vector<Eigen::Vector3d> places_{Eigen::Vector3d::Zero()};
  double slack_m_ = 0;
};

/// Planned place of a vehicle at a moment: the place of a hold, else the path. A trajectory, and
/// the step after it in which the vehicle flies back, may leave the path by PlannedPath::slack_m().
class PlannedPlace {
 public:
  /// @param stages  as flown; they outlive this object
  PlannedPlace(std::span<const Stage> stages, std::span<const FlightStep> steps)
      : stages_(stages), path_(steps) {}

  /// Distance of a vehicle from its planned place, m.
  /// @param time_us  simulated
  /// @param p  place of the vehicle: north, east, up from the start, m
  double distance_m(std::int64_t time_us, const Eigen::Vector3d& p) const;

 private:
  bool landed_before(std::span<const Stage>::iterator end) const;

  std::span<const Stage> stages_;
  PlannedPath path_;
};

bool is_pattern(const Stage& stage) {
  return stage.step.kind == StepKind::kTrajectory || stage.step.kind == StepKind::kEndTrajectory ||
         stage.circle_m > 0;
}

/// Whether a step keeps the vehicle at one place.
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

/// Higher than this above where it stood, a vehicle is in the air; lower than the second it is on
/// the ground, be it on its side.
constexpr double kInAir_m = 0.5;
constexpr double kDown_m = 0.3;
constexpr double kStill_m_s = 0.2;
/// A HEARTBEAT shows a change since the previous one.
constexpr double kHeartbeat_s = 1.0;

Eigen::Vector3d place(const PoseSample& sample, const PoseSample& start) {
  return {sample.pose.x_m - start.pose.x_m, sample.pose.y_m - start.pose.y_m,
          sample.pose.z_m - start.pose.z_m};
}

bool is_crash(IncidentKind kind) { return kind != IncidentKind::kGround; }
bool is_impact(IncidentKind kind) {
  return kind == IncidentKind::kCrash || kind == IncidentKind::kStrike;
}

bool is_finite(const PoseSample& sample) {
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::ranges::all_of(sample.v_m_s, finite) &&
         std::ranges::all_of(
             std::array{sample.pose.x_m, sample.pose.y_m, sample.pose.z_m, sample.pose.roll_rad,
                        sample.pose.pitch_rad, sample.pose.yaw_rad},
             finite);
}

bool has_turning_rotor(const PoseSample& sample) {
  return std::ranges::any_of(sample.omega_rad_s,
                             [](double omega_rad_s) { return omega_rad_s > kTurning_rad_s; });
}

constexpr double kNever_s = std::numeric_limits<double>::infinity();

std::int64_t microseconds(double time_s) { return std::llround(time_s * 1e6); }
double seconds(const PoseSample& sample) { return static_cast<double>(sample.time_us) * 1e-6; }

/// When a vehicle that was struck met the ground or something else.
struct Contact {
  double impact_s = kNever_s;  ///< hit something
  double down_s = kNever_s;    ///< was on the ground after it had been in the air

  double first_s() const { return std::min(impact_s, down_s); }
};

void look_at_incidents(const StrikeEvidence& evidence, StrikeResponse& response, Contact& contact) {
  for (const Incident& incident : find_incidents({evidence.stages.begin(), evidence.stages.end()},
                                                 evidence.truth, evidence.strike_s)) {
    if (!response.incident) response.incident = incident.kind;
    response.crashed |= is_crash(incident.kind);
    if (is_impact(incident.kind)) contact.impact_s = std::min(contact.impact_s, incident.time_s);
  }
}

Contact look_at_motion(const StrikeEvidence& evidence, StrikeResponse& response) {
  Contact contact;
  const auto after = between(evidence.truth, microseconds(evidence.strike_s),
                             std::numeric_limits<std::int64_t>::max());
  if (after.empty()) return contact;
  look_at_incidents(evidence, response, contact);
  const PoseSample& start = evidence.truth.front();
  const PoseSample& last = evidence.truth.back();
  const PlannedPlace plan(evidence.stages, evidence.steps);
  bool turned = false;
  for (const PoseSample& sample : after) {
    if (!is_finite(sample)) {
      response.left_world = true;
      response.farthest_m = std::numeric_limits<double>::infinity();
      break;
    }
    const Eigen::Vector3d p = place(sample, start);
    response.farthest_m = std::max(response.farthest_m, plan.distance_m(sample.time_us, p));
    response.in_air |= p.z() > kInAir_m;
    if (response.in_air && p.z() < kDown_m / 2) {
      contact.down_s = std::min(contact.down_s, seconds(sample));
    }
    if (seconds(sample) >= contact.first_s()) continue;
    response.peak_tilt_deg = std::max(response.peak_tilt_deg, tilt_deg(sample.pose));
    turned |= has_turning_rotor(sample);
    response.terminated |=
        !evidence.stops_rotors && turned && !has_turning_rotor(sample) && p.z() > kInAir_m;
  }
  const Eigen::Vector3d end = place(last, start);
  const double speed = std::hypot(last.v_m_s[0], last.v_m_s[1], last.v_m_s[2]);
  response.at_rest = end.z() < kDown_m && speed < kStill_m_s;
  response.crashed |= -last.v_m_s[2] > kCrashSpeed_m_s;
  response.rest_m = (end - place(after.front(), start)).head<2>().norm();
  return contact;
}

/// Measures the response within the hold that the fault struck: the steps after it move and tilt
/// the vehicle by themselves.
void look_at_hold(const StrikeEvidence& evidence, StrikeResponse& response) {
  const auto struck = std::ranges::find_if(evidence.stages, [&](const Stage& stage) {
    return keeps_place(stage) && base::to_seconds(stage.begin) <= evidence.strike_s &&
           evidence.strike_s < base::to_seconds(stage.end);
  });
  if (struck == evidence.stages.end()) return;
  const auto hold = between(evidence.truth, microseconds(evidence.strike_s),
                            static_cast<std::int64_t>(base::to_time_usec(struck->end)));
  if (!std::ranges::all_of(hold, is_finite)) return;
  for (const PoseSample& sample : hold) {
    response.hold_farthest_m =
        std::max(response.hold_farthest_m.value_or(0), place(sample, hold.front()).norm());
    response.hold_tilt_deg = std::max(response.hold_tilt_deg.value_or(0), tilt_deg(sample.pose));
  }
}

/// Whether the vehicle is in the air at a moment.
bool is_in_air(const StrikeEvidence& evidence, double time_s) {
  const auto before = between(evidence.truth, 0, microseconds(time_s) + 1);
  return !before.empty() && place(before.back(), evidence.truth.front()).z() > kInAir_m;
}

/// When the flight of a vehicle that was struck in the air was over: its plan, or it was disarmed
/// on the ground.
double flight_end_s(const StrikeEvidence& evidence) {
  if (evidence.stages.empty() || !is_in_air(evidence, evidence.strike_s)) return kNever_s;
  const auto landed =
      std::ranges::find_if(evidence.messages.armed, [&evidence](const ArmedChange& change) {
        return !change.armed && change.time_s >= evidence.strike_s &&
               !is_in_air(evidence, change.time_s);
      });
  return std::min(base::to_seconds(evidence.stages.back().end),
                  landed == evidence.messages.armed.end() ? kNever_s : landed->time_s);
}

/// Whether the vehicle had landed and was disarmed, and no step would arm it again.
bool flight_was_over(const StrikeEvidence& evidence) {
  const auto armed_steps = [&](const Stage& stage) {
    return stage.step.kind == StepKind::kArm && base::to_seconds(stage.end) > evidence.strike_s;
  };
  if (std::ranges::any_of(evidence.stages, armed_steps)) return false;
  const auto earlier = std::ranges::lower_bound(evidence.messages.armed, evidence.strike_s, {},
                                                &ArmedChange::time_s);
  if (earlier == evidence.messages.armed.begin() || std::prev(earlier)->armed) return false;
  const bool flew = std::ranges::any_of(
      between(evidence.truth, 0, microseconds(evidence.strike_s)), [&](const PoseSample& sample) {
        return place(sample, evidence.truth.front()).z() > kInAir_m;
      });
  return flew && !is_in_air(evidence, evidence.strike_s);
}

/// Why a flight has no verdict on its fault; nullopt when it has one.
std::optional<std::string> why_no_verdict(const StrikeEvidence& evidence) {
  if (evidence.stages.empty()) return "struck before the flight, which did not begin";
  if (evidence.strike_s >= base::to_seconds(evidence.stages.back().end) ||
      flight_was_over(evidence)) {
    return "never acted: it struck after the flight";
  }
  if (evidence.truth.empty() || seconds(evidence.truth.back()) < evidence.strike_s) {
    return "no true motion was recorded after the strike";
  }
  return std::nullopt;
}

/// Arming is asked for each second: a step that was under way may have been answered before.
bool tried_to_arm(const StrikeEvidence& evidence) {
  return std::ranges::any_of(evidence.stages, [&](const Stage& stage) {
    constexpr double kRetry_s = 1.0;
    return stage.step.kind == StepKind::kArm &&
           (base::to_seconds(stage.begin) >= evidence.strike_s ||
            base::to_seconds(stage.end) >= evidence.strike_s + kRetry_s);
  });
}

/// Whether a fault of this name takes the rotors' speed by physics.
bool stops_rotors(std::span<const VehicleFault> faults, const std::string& name) {
  std::size_t number = 0;
  return std::ranges::any_of(faults, [&](const VehicleFault& fault) {
    const sim::FaultSpec spec = sim::parse_fault(fault.script, ++number);
    return spec.name == name && sim::breaks_propulsion(spec.kind);
  });
}

void note(const StrikeEvidence& evidence, const VehicleSign& sign, StrikeResponse& response) {
  const double after_s = sign.time_s - evidence.strike_s;
  if (!response.detected_s || after_s < *response.detected_s) {
    response.detected_s = after_s;
    response.detected_by = sign.what;
  }
  if (!sign.is_reaction) return;
  if (!response.reacted_s || after_s < *response.reacted_s) {
    response.reacted_s = after_s;
    response.reaction = sign.what;
  }
}

}  // namespace

StrikeResponse strike_response(const StrikeEvidence& evidence) {
  StrikeResponse response{
      .strike_s = evidence.strike_s, .fault = evidence.fault, .completed = evidence.completed};
  response.no_verdict = why_no_verdict(evidence);
  response.tried_to_arm = tried_to_arm(evidence);
  const Contact contact = look_at_motion(evidence, response);
  look_at_hold(evidence, response);
  const double until_s =
      std::min({contact.impact_s, evidence.end_s ? *evidence.end_s + kHeartbeat_s : kNever_s,
                flight_end_s(evidence)});
  for (const VehicleSign& sign : evidence.messages.signs) {
    if (sign.time_s < evidence.strike_s || sign.time_s > until_s) continue;
    note(evidence, sign, response);
    response.terminated |=
        sign.is_reaction && sign.what == "TERMINATION" && sign.time_s <= contact.first_s();
  }
  for (const auto& [time_s, armed] : evidence.messages.armed) {
    if (time_s < evidence.strike_s) {
      response.armed_before = armed;
      continue;
    }
    response.armed_after |= armed;
    if (armed || time_s > std::min(until_s, contact.down_s) || !is_in_air(evidence, time_s))
      continue;
    response.terminated = true;
    note(evidence, {.time_s = time_s, .what = "disarmed in the air", .is_reaction = true},
         response);
  }
  response.armed_after |= response.armed_before;
  return response;
}

std::optional<StrikeResponse> read_strike_response(const RunRecord& record,
                                                   std::span<const FlightStep> steps,
                                                   std::span<const VehicleFault> faults,
                                                   std::span<const PoseSample> truth) {
  const auto first = std::ranges::min_element(record.faults, {}, &BenchFaultScript::Span::begin);
  if (first == record.faults.end()) return std::nullopt;
  std::optional<double> end_s = 0;
  for (const BenchFaultScript::Span& span : record.faults) {
    if (span.name != first->name || !end_s) continue;
    end_s = span.end ? std::optional(std::max(*end_s, base::to_seconds(*span.end))) : std::nullopt;
  }
  std::vector<Stage> stages = record.stages;
  if (record.under_way) stages.push_back(*record.under_way);
  return strike_response({.strike_s = base::to_seconds(first->begin),
                          .end_s = end_s,
                          .fault = first->name,
                          .stops_rotors = stops_rotors(faults, first->name),
                          .stages = stages,
                          .steps = steps,
                          .completed = !record.flight_failure,
                          .truth = truth,
                          .messages = read_vehicle_messages(record)});
}

}  // namespace cas::hils
