// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/flight/flight_step.hpp"

namespace cas::hils {

/// Takes the vehicles of a scenario through its steps together: a step begins for all of them at
/// the same moment, when each is through with the one before. One vehicle alone is a fleet, too.
///
///   update() -> commands -> on_outcome() of each -> update() ...
class FleetPlan {
 public:
  /// @param start_yaw_rad  heading of each vehicle at the start, in the order of their names
  FleetPlan(VehicleNames names, const std::vector<FlightStep>& steps,
            std::span<const double> start_yaw_rad, FirmwareHabits habits = {});

  /// A command that is due now.
  struct Command {
    std::size_t vehicle = 0;
    FlightStep step;
  };
  /// Looks at all vehicles, in the order of the scenario.
  std::vector<Command> update(base::SimTime now, std::span<const VehicleReport> vehicles);
  /// A vehicle's answer to its last command, as FlightPlan takes it.
  void on_outcome(std::size_t vehicle, base::SimTime now,
                  const std::optional<Refusal>& refusal = {});

  /// Every vehicle is through, or one of them cannot go on.
  bool ended() const;
  /// Phase of the flight: the first step that not all vehicles have done.
  std::string_view phase() const { return plans_[slowest()].phase(); }
  /// The first vehicle that does something in the step under way, for progress lines.
  std::size_t leader() const;
  const FlightPlan& plan(std::size_t vehicle) const { return plans_[vehicle]; }
  FlightPlan& plan(std::size_t vehicle) { return plans_[vehicle]; }
  /// Why a vehicle's flight is not complete, be it another's fault; empty when it is, or while it
  /// goes on.
  std::optional<std::string> failure_of(std::size_t vehicle) const;

 private:
  std::optional<std::string> lack_before_arming(std::span<const VehicleReport> vehicles) const;
  std::size_t slowest() const;
  std::size_t others_through(std::size_t vehicle) const;
  std::size_t progress() const;

  VehicleNames names_;
  std::vector<FlightPlan> plans_;
};

}  // namespace cas::hils
