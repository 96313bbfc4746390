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

/// Limits of a vehicle that can be evaluated during the flight: its errors from the reference in
/// the measured step so far. Packets and delays need the programs' finished ledgers, responses and
/// incidents the finished flight.
class FiguresSoFar {
 public:
  /// Adds one sample of the vehicle; only those in the measured step count, each moment once, and
  /// each estimate once while it is fresh. Everything restarts if simulated time goes back. @param
  /// stage  the current step
  void add(const Stage& stage, base::SimTime now, const VehicleReport& vehicle);

  /// The limits on the flight, in the order and with the names of judge(); those not known yet have
  /// a bound but no value. Figures without a bound are left out.
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
