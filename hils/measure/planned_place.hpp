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

/// The lines between the places of a plan, from the start to the landing.
class PlannedPath {
 public:
  explicit PlannedPath(std::span<const FlightStep> steps);

  double distance_m(const Eigen::Vector3d& p) const;
  /// How far its trajectories lead from it.
  double slack_m() const { return slack_m_; }

 private:
  std::vector<Eigen::Vector3d> places_{Eigen::Vector3d::Zero()};
  double slack_m_ = 0;  ///< trajectories fly about their place
};

/// Where the plan has a vehicle at a moment: in a hold at its place, else on the path; within its
/// size in a trajectory, and in the step after it, where the vehicle flies back.
class PlannedPlace {
 public:
  /// @param stages  as flown; they outlive this object
  PlannedPlace(std::span<const Stage> stages, std::span<const FlightStep> steps)
      : stages_(stages), path_(steps) {}

  /// How far a vehicle is from there, m.
  /// @param time_us  simulated @param p  from where it stood, north, east, up, m
  double distance_m(std::int64_t time_us, const Eigen::Vector3d& p) const;

 private:
  bool landed_before(std::span<const Stage>::iterator end) const;

  std::span<const Stage> stages_;
  PlannedPath path_;
};

}  // namespace cas::hils
