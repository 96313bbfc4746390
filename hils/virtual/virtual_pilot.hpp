// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/station/gain_map.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "hils/scenario/fleet_plan.hpp"

namespace cas::hils {

/// Flies the vehicles of a scenario through casd's ground station on the virtual clock.
class VirtualPilot {
 public:
  /// True motion of a vehicle, from the simulator.
  using Truth = std::function<Motion(std::size_t vehicle)>;

  VirtualPilot(casd::VehicleCommander& commander, const Scenario& scenario, casd::GainMap gains,
               Truth truth);
  VirtualPilot(const VirtualPilot&) = delete;
  VirtualPilot& operator=(const VirtualPilot&) = delete;

  /// The time that answers come at, between calls of `run`.
  void set_now(base::RunTime now) { now_ = now; }
  /// Looks at the vehicles and gives the commands that are due.
  void run(base::RunTime now);
  base::RunTime next_event() const { return next_look_; }

  const FleetPlan& plan() const { return plan_; }
  const std::vector<VehicleReport>& vehicles() const { return vehicles_; }

 private:
  VehicleReport look(std::size_t vehicle) const;
  void give(const FleetPlan::Command& command, base::RunTime now);
  void set_gain(std::uint8_t system, const FlightStep& step, base::RunTime now, casd::Done done);
  void set_params(std::uint8_t system, const FlightStep& step, std::size_t index, base::RunTime now,
                  casd::Done done);

  casd::VehicleCommander& commander_;
  std::vector<std::uint8_t> systems_;
  casd::GainMap gains_;
  FleetPlan plan_;
  Truth truth_;
  std::vector<VehicleReport> vehicles_;
  base::RunTime now_{};
  base::RunTime next_look_{};
};

}  // namespace cas::hils
