// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/incident.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "base/angles.hpp"
#include "hils/measure/struck_object.hpp"

namespace cas::hils {

namespace {

/// Lower than this above where it stood, a vehicle touches the ground.
constexpr double kTouch_m = 0.02;
/// An impact below this height is on the ground: a vehicle that falls on its arm is that high.
constexpr double kNear_m = 0.5;
/// More than rotors or gusts can do: only a solid object slows a vehicle like this. 6 g.
constexpr double kImpact_m_s2 = 60.0;
constexpr double kLeastExtent_m = 1.0;

double norm(const std::array<double, 3>& v) { return std::hypot(v[0], v[1], v[2]); }

/// Farthest place of the plan from the start.
double extent_m(const std::vector<Stage>& stages) {
  double extent = kLeastExtent_m;
  for (const Stage& stage : stages) {
    extent =
        std::max({extent, stage.reference_m.norm() + stage.step.trajectory.size_m + stage.circle_m,
                  stage.step.reach_m});
  }
  return extent;
}

/// How a step is flown.
enum class Place { kGround, kRising, kAir, kSinking };

/// Goes through the samples of a flight and keeps the first incident of each kind from a moment on.
class Watch {
 public:
  Watch(const PoseSample& start, double farthest_m, double from_s)
      : start_(start), farthest_m_(farthest_m), from_s_(from_s) {}

  /// @param on_wing  the vehicle rolls on the ground before its flight and after it
  void look(const PoseSample& before, const PoseSample& now, Place place, bool on_wing,
            std::string_view step) {
    if (place == Place::kGround) return;
    const auto in_step = [&] {
      return fmt::format("in step '{}' at {:.2f} s", step, seconds(now));
    };
    const bool low = now.pose.z_m - start_.pose.z_m < kTouch_m;
    if (low && place == Place::kAir)
      note(IncidentKind::kGround, now, "touched the ground " + in_step());
    const bool rolls = on_wing && place != Place::kAir;
    const double speed_m_s = rolls ? std::abs(before.v_m_s[2]) : norm(before.v_m_s);
    if (is_impact(before, now) && speed_m_s > kCrashSpeed_m_s) {
      note(IncidentKind::kCrash, now,
           fmt::format("hit {} at {:.1f} m/s {}",
                       now.pose.z_m - start_.pose.z_m < kNear_m ? "the ground" : kSomething,
                       speed_m_s, in_step()));
    }
    const double tilt = tilt_deg(now.pose);
    if (tilt > kMostTilt_deg) {
      note(IncidentKind::kAttitude, now,
           fmt::format("tilted by {:.0f} degrees {}", tilt, in_step()));
    }
    if (const auto rotor = struck_rotor(before, now)) {
      note(
          IncidentKind::kStrike, now,
          fmt::format("hit {} with rotor {}, which stopped {}", kSomething, *rotor + 1, in_step()));
    }
    const double away_m = norm({now.pose.x_m - start_.pose.x_m, now.pose.y_m - start_.pose.y_m,
                                now.pose.z_m - start_.pose.z_m});
    if (!(away_m <= farthest_m_)) {
      note(IncidentKind::kFlyaway, now,
           fmt::format("flew {:.0f} m away {}, and the plan asks for {:.0f} m at most", away_m,
                       in_step(), farthest_m_ / kFarthestExtents));
    }
  }

  /// A vehicle that falls when the record ends hits the ground after it.
  void look_at_end(const PoseSample& last, std::string_view step) {
    const double sink_m_s = -last.v_m_s[2];
    if (sink_m_s <= kCrashSpeed_m_s) return;
    note(IncidentKind::kCrash, last,
         fmt::format("was still falling at {:.1f} m/s when the record ended, after step '{}'",
                     sink_m_s, step));
  }

  std::vector<Incident> found;

 private:
  static double seconds(const PoseSample& sample) {
    return static_cast<double>(sample.time_us) * 1e-6;
  }
  /// A struck rotor stops from one sample to the next while others turn. A rotor that is switched
  /// off turns on for its lag, and disarming stops all rotors.
  static std::optional<std::size_t> struck_rotor(const PoseSample& before, const PoseSample& now) {
    const auto turns = [](double omega_rad_s) { return omega_rad_s > 0; };
    if (std::ranges::none_of(now.omega_rad_s, turns)) return std::nullopt;
    for (std::size_t i = 0; i < now.omega_rad_s.size(); ++i) {
      if (before.omega_rad_s[i] > kTurning_rad_s && !turns(now.omega_rad_s[i])) return i;
    }
    return std::nullopt;
  }
  static bool is_impact(const PoseSample& before, const PoseSample& now) {
    const double dt_s = seconds(now) - seconds(before);
    const std::array<double, 3> change{now.v_m_s[0] - before.v_m_s[0],
                                       now.v_m_s[1] - before.v_m_s[1],
                                       now.v_m_s[2] - before.v_m_s[2]};
    return dt_s > 0 && norm(change) / dt_s > kImpact_m_s2 && norm(now.v_m_s) < norm(before.v_m_s);
  }
  void note(IncidentKind kind, const PoseSample& at, std::string what) {
    if (seconds(at) < from_s_) return;
    if (std::ranges::find(found, kind, &Incident::kind) != found.end()) return;
    found.push_back({kind, seconds(at), std::move(what)});
  }

  const PoseSample& start_;
  double farthest_m_;
  double from_s_;
};

/// How the next step is flown, after this one began.
Place place_in(const FlightStep& step, Place before) {
  if (lands(step)) return Place::kSinking;
  if (takes_off(step)) return Place::kRising;
  switch (step.kind) {
    case StepKind::kArm:
      return Place::kGround;
    case StepKind::kDisarm:
      return before;  // a vehicle may be disarmed in the air, and falls
    default:
      return before == Place::kRising ? Place::kAir : before;
  }
}

}  // namespace

double tilt_deg(const Pose& pose) {
  const double upright = std::cos(pose.roll_rad) * std::cos(pose.pitch_rad);
  return base::degrees(std::acos(std::clamp(upright, -1.0, 1.0)));
}

std::vector<Incident> find_incidents(const std::vector<Stage>& stages,
                                     std::span<const PoseSample> truth, double from_s) {
  if (truth.empty()) return {};
  Watch watch(truth.front(), kFarthestExtents * extent_m(stages), from_s);
  Place place = Place::kGround;
  const PoseSample* before = &truth.front();
  for (std::size_t i = 0; i < stages.size(); ++i) {
    const Stage& stage = stages[i];
    place = place_in(stage.step, place);
    // Time between two steps, and after the last one, belongs to the step before.
    const std::int64_t until = i + 1 < stages.size() ? to_microseconds(stages[i + 1].begin)
                                                     : std::numeric_limits<std::int64_t>::max();
    for (const PoseSample& sample : between(truth, to_microseconds(stage.begin), until)) {
      watch.look(*before, sample, place, stage.on_wing, phase_of(stage.step));
      before = &sample;
    }
  }
  if (place == Place::kSinking) watch.look_at_end(*before, phase_of(stages.back().step));
  return watch.found;
}

}  // namespace cas::hils
