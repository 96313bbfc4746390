// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/measure/limit_check.hpp"
#include "hils/measure/tracking.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// A vehicle's limits in flight: its errors from the reference over the measured step, up to now.
/// Packets and delays are known when the programs have written their ledgers, responses and
/// incidents when the flight is over.
class FiguresSoFar {
 public:
  /// One look at the vehicle; only those in the measured step count, each moment once, and each
  /// estimate once while it is fresh. Everything restarts when simulated time goes back.
  /// @param stage  the step under way
  void add(const Stage& stage, base::SimTime now, const VehicleReport& vehicle);

  /// The limits on the flight as judge() has them, in its order and by its names; those not known
  /// yet have a bound and no value. Entries without a bound are left out.
  std::vector<LimitCheck> checks(const Limits& limits) const;

 private:
  RmsSums truth_;
  RmsSums estimate_;
  std::optional<base::SimTime> newest_;
  /// Place and velocity of the estimate that was counted last.
  std::optional<std::pair<Eigen::Vector3d, Eigen::Vector3d>> counted_;
};

/// Where the vehicle shall be now; nothing before it climbs and from its landing on.
std::optional<Stage> reference_stage(const FlightPlan& plan, base::SimTime now);

}  // namespace cas::hils
