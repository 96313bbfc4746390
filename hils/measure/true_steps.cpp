// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/true_steps.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "base/time/clock.hpp"

namespace cas::hils {
namespace {

/// Largest error of a stock autopilot's estimate (2 m) plus the radius within which a place counts
/// as reached: 2 m for multicopters (PX4 NAV_ACC_RAD, ArduCopter WPNAV_RADIUS).
constexpr double kOff_m = 4;
/// Share of the distance from home: projections of the autopilot and of the simulator differ.
constexpr double kOffShare = 0.01;
/// Share of a trajectory's extent: a vehicle that lags behind or rounds corners still covers more.
constexpr double kLeastOfExtent = 0.5;
/// Share of the mean square of the rotors' speeds in flight, which is proportional to thrust: a
/// vehicle with less is on the ground.
constexpr double kCarries = 0.7;
/// Length of the end of the record in which the rotors' speeds are checked.
constexpr std::int64_t kTail_us = 200'000;

Eigen::Vector3d place_of(const PoseSample& sample) {
  return {sample.pose.x_m, sample.pose.y_m, sample.pose.z_m};
}

const PoseSample& sample_at(std::span<const PoseSample> truth, base::SimTime time) {
  const auto next =
      std::ranges::lower_bound(truth, to_microseconds(time), {}, &PoseSample::time_us);
  return next == truth.end() ? truth.back() : *next;
}

/// Not-a-number is not near.
bool is_near(double off_m, double distance_m, double radius_m = 0) {
  return off_m <= std::max(kOff_m, radius_m + kOff_m / 2) + kOffShare * distance_m;
}

bool ends_at_a_place(const FlightStep& step) {
  switch (step.kind) {
    case StepKind::kTakeoff:
    case StepKind::kGoto:
    case StepKind::kLoiter:
    case StepKind::kRtl:
    case StepKind::kMission:
      return true;
    default:
      return false;
  }
}

/// @param origin_m  where the vehicle took off
std::optional<std::string> not_there(const Stage& stage, const Eigen::Vector3d& origin_m,
                                     std::span<const PoseSample> truth) {
  if (!ends_at_a_place(stage.step)) return std::nullopt;
  Eigen::Vector3d off_m = place_of(sample_at(truth, stage.end)) - origin_m - stage.reference_m;
  const bool any_height = lands(stage.step) || stage.step.kind == StepKind::kRtl;
  if (any_height) off_m.z() = 0;  // the ground there may be higher or lower
  if (stage.on_wing && stage.step.kind == StepKind::kTakeoff) off_m.head<2>().setZero();
  if (stage.circle_m > 0) off_m = {off_m.head<2>().norm() - stage.circle_m, 0, off_m.z()};
  const double run_out_m = stage.on_wing && lands(stage.step) ? kRunOut_m : 0;
  const double reached_m = std::max(run_out_m, kOnCircleShare * stage.circle_m);
  if (is_near(off_m.norm(), stage.reference_m.norm(), reached_m)) return std::nullopt;
  return fmt::format("step '{}' ended {:.1f} m from its place", phase_of(stage.step), off_m.norm());
}

/// Without the height where that counts from the terrain.
double distance_m(const MissionPlace& place, const PoseSample& sample,
                  const Eigen::Vector3d& origin_m) {
  const Eigen::Vector3d off = place_of(sample) - origin_m - place.place_m;
  return place.above_terrain ? off.head<2>().norm() : off.norm();
}

/// The first waypoint that the vehicle did not come near, after those before it.
std::optional<std::string> skipped(const Stage& stage, const Eigen::Vector3d& origin_m,
                                   std::span<const PoseSample> flown) {
  const std::vector<std::size_t> passed = passings(stage.step.places, origin_m, flown);
  if (passed.size() == stage.step.places.size()) return std::nullopt;
  const MissionPlace& place = stage.step.places[passed.size()];
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const PoseSample& sample : flown.subspan(passed.empty() ? 0 : passed.back())) {
    nearest_m = std::min(nearest_m, distance_m(place, sample, origin_m));
  }
  return fmt::format("step '{}' came no nearer than {:.1f} m to the place of item {}",
                     phase_of(stage.step), nearest_m, place.number);
}

/// Least and greatest coordinates of a path.
struct Box {
  Eigen::Vector3d least_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d most_m = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());

  void add(const Eigen::Vector3d& place_m) {
    least_m = least_m.cwiseMin(place_m);
    most_m = most_m.cwiseMax(place_m);
  }
  Eigen::Vector3d extent_m() const { return most_m - least_m; }
};

std::optional<std::string> hardly_moved(const Stage& stage, std::span<const PoseSample> flown) {
  Box wanted;
  Box found;
  for (const PoseSample& sample : flown) {
    const Pose reference = reference_at(stage, sample.time_us);
    wanted.add({reference.x_m, reference.y_m, reference.z_m});
    found.add(place_of(sample));
  }
  for (const Eigen::Index axis : {0, 1, 2}) {
    const double wanted_m = wanted.extent_m()[axis];
    const double found_m = found.extent_m()[axis];
    if (found_m >= kLeastOfExtent * wanted_m) continue;
    return fmt::format("step '{}' moved {:.1f} m {}, and its path goes over {:.1f} m",
                       phase_of(stage.step), found_m,
                       axis == 0   ? "north to south"
                       : axis == 1 ? "east to west"
                                   : "up and down",
                       wanted_m);
  }
  return std::nullopt;
}

double mean_square(const PoseSample& sample) {
  double sum = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(sample.rotors); ++i) {
    sum += sample.omega_rad_s[i] * sample.omega_rad_s[i];
  }
  return sample.rotors > 0 ? sum / sample.rotors : 0;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<double> mean_squares(std::span<const PoseSample> samples) {
  std::vector<double> all;
  for (const PoseSample& sample : samples) all.push_back(mean_square(sample));
  return all;
}

/// @param took_off  begin of the last takeoff
/// @param landing  the last step that lands
std::optional<std::string> flies_on(base::SimTime took_off, const Stage& landing,
                                    std::span<const PoseSample> truth) {
  const auto flight = between(truth, to_microseconds(took_off), to_microseconds(landing.end));
  const std::int64_t last_us = truth.back().time_us;
  const auto tail = between(truth, last_us - kTail_us, last_us + 1);
  if (flight.empty() || tail.empty()) return std::nullopt;
  const double hover = median(mean_squares(flight));
  if (!(hover > 0) || median(mean_squares(tail)) < kCarries * hover) return std::nullopt;
  return fmt::format(
      "step '{}' ended on the ground by the vehicle's word, and its rotors turn as "
      "in flight to the end of the record",
      phase_of(landing.step));
}

}  // namespace

std::vector<std::size_t> passings(std::span<const MissionPlace> places,
                                  const Eigen::Vector3d& origin_m,
                                  std::span<const PoseSample> flown) {
  std::vector<std::size_t> passed;
  auto from = flown.begin();
  for (const MissionPlace& place : places) {
    from = std::find_if(from, flown.end(), [&](const PoseSample& sample) {
      return is_near(distance_m(place, sample, origin_m), place.place_m.norm(), place.radius_m);
    });
    if (from == flown.end()) return passed;
    passed.push_back(static_cast<std::size_t>(from - flown.begin()));
  }
  return passed;
}

std::vector<std::string> steps_not_flown(const std::vector<Stage>& stages,
                                         std::span<const PoseSample> truth) {
  std::vector<std::string> missing;
  if (truth.empty()) return missing;
  const auto note = [&missing](const std::optional<std::string>& sentence) {
    if (sentence) missing.push_back(*sentence);
  };
  const Stage* takeoff = nullptr;
  const Stage* landing = nullptr;
  for (const Stage& stage : stages) {
    if (takes_off(stage.step)) {
      takeoff = &stage;
      landing = nullptr;
    }
    if (takeoff == nullptr) continue;
    if (lands(stage.step)) landing = &stage;
    const Eigen::Vector3d origin_m = place_of(sample_at(truth, takeoff->begin));
    const auto flown = between(truth, to_microseconds(stage.accepted), to_microseconds(stage.end));
    note(not_there(stage, origin_m, truth));
    note(skipped(stage, origin_m, flown));
    if (stage.step.kind == StepKind::kTrajectory) note(hardly_moved(stage, flown));
  }
  if (landing != nullptr) note(flies_on(takeoff->begin, *landing, truth));
  return missing;
}

}  // namespace cas::hils
