// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/flight/fleet_plan.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/flight/flight_step.hpp"

namespace cas::hils {

/// The stream goes on for this long after the flight, so that the pipe is drained.
inline constexpr base::Duration kDrain = std::chrono::seconds(1);

/// A flight under way.
struct Flight {
  Flight(VehicleNames names, const std::vector<FlightStep>& steps,
         std::span<const double> start_yaw_rad, std::vector<BenchFault> bench_faults,
         FirmwareHabits habits = {})
      : vehicles(names.size()),
        plan(std::move(names), steps, start_yaw_rad, habits),
        faults(std::move(bench_faults)) {}

  std::vector<VehicleReport> vehicles;  ///< newest reports, positions from the place of arming
  FleetPlan plan;
  BenchFaultScript faults;
};

/// Where a flight is flown: simulator, casd and controllers in any composition, as FlightLoop
/// reaches them.
class FlightBench {
 public:
  /// A vehicle's answer to a command. @param refusal  nullopt: it was accepted
  using Answer = std::function<void(base::SimTime now, const std::optional<Refusal>& refusal)>;

  virtual ~FlightBench() = default;

  /// Looks at the simulation. @return its time
  virtual base::SimTime look() = 0;
  /// True motion at that look, from where the vehicle stood at first.
  virtual Motion truth(std::size_t vehicle) const = 0;
  /// State of a vehicle now, its position from its own origin; nullopt: it is out of sight for a
  /// reason that is no fault of its own, and the steps wait for it.
  virtual std::optional<VehicleReport> report(std::size_t vehicle) = 0;
  /// After each look, before the steps go on.
  virtual void before_steps(Flight&, base::SimTime) {}
  /// After the steps have gone on, before faults and commands; not while a vehicle is out of sight.
  virtual void after_steps(Flight&, base::SimTime) {}
  /// The flight has a new phase.
  virtual void tell_phase(std::string_view phase) = 0;
  virtual void play(const Flight& flight, const BenchFault& fault, bool begins) = 0;
  /// Shows how far the first vehicle of the step under way is.
  virtual void show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle) = 0;
  /// Has a vehicle do a step. @param answer  called once, before give() returns or later
  virtual void give(Flight& flight, std::size_t vehicle, const FlightStep& step, Answer answer) = 0;
};

/// Takes the vehicles of a flight through their steps, in turns:
///
///   look -> steps -> phase -> faults -> show -> commands -> answers, at once or later
///
/// Every kind of run flies with it, over a FlightBench of its own: real time, lockstep, stock
/// firmware and the virtual clock. A flight of two steps, say takeoff and land: fly() gives takeoff
/// in the first turns, looks until its condition holds, gives land, and returns once the plan has
/// ended.
class FlightLoop {
 public:
  /// @param bench  outlives the loop
  FlightLoop(Flight flight, FlightBench& bench) : flight_(std::move(flight)), bench_(bench) {}
  FlightLoop(const FlightLoop&) = delete;
  FlightLoop& operator=(const FlightLoop&) = delete;

  /// @return whether a command was given
  bool turn();
  /// Takes turns until the plan has ended. @param wait  between two turns
  void fly(const std::function<void(bool commanded)>& wait);

  Flight& flight() { return flight_; }
  const Flight& flight() const { return flight_; }

 private:
  bool look_at_vehicles();
  void tell_phase();
  bool give(const std::vector<FleetPlan::Command>& commands);

  Flight flight_;
  FlightBench& bench_;
  std::string phase_;  ///< the bench's
};

}  // namespace cas::hils
