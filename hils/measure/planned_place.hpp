// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "hils/flight/flight_plan.hpp"

namespace cas::hils {

/// Whether a step keeps the vehicle at one place.
bool keeps_place(const Stage& stage);

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

}  // namespace cas::hils
