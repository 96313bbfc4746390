// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "base/clock.hpp"
#include "casd/gain_map.hpp"
#include "casd/vehicle_commander.hpp"
#include "hils/flight_plan.hpp"

namespace cas::hils {

/// Flies a plan through casd's ground station on the virtual clock.
class VirtualPilot {
 public:
  /// What the simulator knows of the vehicle's motion.
  using Truth = std::function<Motion()>;

  VirtualPilot(casd::VehicleCommander& commander, std::uint8_t system, casd::GainMap gains,
               std::vector<FlightStep> steps, Truth truth);
  VirtualPilot(const VirtualPilot&) = delete;
  VirtualPilot& operator=(const VirtualPilot&) = delete;

  /// The time that answers come at, between calls of `run`.
  void set_now(base::RunTime now) { now_ = now; }
  /// Looks at the vehicle and gives the command that is due.
  void run(base::RunTime now);
  base::RunTime next_event() const { return next_look_; }

  const FlightPlan& plan() const { return plan_; }
  const VehicleReport& vehicle() const { return vehicle_; }

 private:
  VehicleReport look() const;
  void give(const FlightStep& step, base::RunTime now);
  void set_gain(const FlightStep& step, base::RunTime now, casd::Done done);
  void set_params(const FlightStep& step, std::size_t index, base::RunTime now, casd::Done done);

  casd::VehicleCommander& commander_;
  std::uint8_t system_;
  casd::GainMap gains_;
  FlightPlan plan_;
  Truth truth_;
  VehicleReport vehicle_;
  base::RunTime now_{};
  base::RunTime next_look_{};
};

}  // namespace cas::hils
