// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/scenario_flight.hpp"

namespace cas::hils {

Flight flight_of(const Scenario& scenario) {
  return {scenario.names(), scenario.steps, scenario.start_yaws_rad(), scenario.faults.bench};
}

void record_flight(const Flight& flight, std::size_t vehicle, base::SimTime now,
                   RunRecord& record) {
  const FlightPlan& plan = flight.plan.plan(vehicle);
  record.simulated_s = base::to_seconds(now);
  record.flight_failure = flight.plan.failure_of(vehicle);
  record.stages = plan.stages();
  record.under_way = plan.under_way(now);
  record.hold = plan.measured();
  record.faults = flight.faults.history_of(vehicle);
}

}  // namespace cas::hils
