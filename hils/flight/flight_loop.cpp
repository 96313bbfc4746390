// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/flight_loop.hpp"

namespace cas::hils {

bool FlightLoop::turn() {
  const base::SimTime now = bench_.look();
  const bool all_in_sight = look_at_vehicles();
  bench_.before_steps(flight_, now);
  std::vector<FleetPlan::Command> commands;
  if (all_in_sight) {
    commands = flight_.plan.update(now, flight_.vehicles);
    tell_phase();
    bench_.after_steps(flight_, now);
  }
  for (const auto& [fault, begins] :
       flight_.faults.update(now, flight_.vehicles, flight_.plan.phase())) {
    bench_.play(flight_, *fault, begins);
  }
  if (flight_.plan.ended()) return false;
  const std::size_t leader = flight_.plan.leader();
  bench_.show(now, flight_.plan.plan(leader), flight_.vehicles[leader]);
  return give(commands);
}

void FlightLoop::fly(const std::function<void(bool commanded)>& wait) {
  for (bool commanded = turn(); !flight_.plan.ended(); commanded = turn()) wait(commanded);
}

/// @return whether none is out of sight
bool FlightLoop::look_at_vehicles() {
  bool all_in_sight = true;
  for (std::size_t i = 0; i < flight_.vehicles.size(); ++i) {
    VehicleReport& vehicle = flight_.vehicles[i];
    std::optional<VehicleReport> report = bench_.report(i);
    if (report) vehicle = flight_.plan.plan(i).from_arming(std::move(*report));
    vehicle.truth = bench_.truth(i);
    all_in_sight = all_in_sight && report;
  }
  return all_in_sight;
}

void FlightLoop::tell_phase() {
  if (flight_.plan.phase() == phase_) return;
  phase_ = flight_.plan.phase();
  bench_.tell_phase(phase_);
}

bool FlightLoop::give(const std::vector<FleetPlan::Command>& commands) {
  for (const auto& [vehicle, step] : commands) {
    if (flight_.plan.ended()) break;
    bench_.give(flight_, vehicle, step,
                [this, i = vehicle](base::SimTime now, const std::optional<Refusal>& refusal) {
                  flight_.plan.on_outcome(i, now, refusal);
                });
  }
  return !commands.empty();
}

}  // namespace cas::hils
