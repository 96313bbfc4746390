// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/never_began.hpp"

#include <algorithm>

#include "plugins/fault/fault_spec.hpp"

namespace cas::hils {

std::vector<FaultThatNeverBegan> faults_that_never_began(
    const ScenarioFaults& faults, std::size_t vehicle,
    const std::vector<BenchFaultScript::Span>& begun, const std::vector<Stage>& stages) {
  std::vector<FaultThatNeverBegan> never;
  for (const BenchFault& fault : faults.bench) {
    if (!fault.is_everybodys() && fault.vehicle != vehicle) continue;
    never.push_back({.name = fault.name, .by_time = fault.at.has_value()});
  }
  std::size_t number = 0;  // as the vehicle's plugin counts them
  for (const VehicleFault& fault : faults.vehicle) {
    if (fault.vehicle.value_or(vehicle) != vehicle) continue;
    never.push_back({.name = sim::parse_fault(fault.script, ++number).name,
                     .by_time = fault.script.has("at_s")});
  }
  for (const BenchFaultScript::Span& span : begun) {
    const bool after = !stages.empty() && span.begin > stages.back().end;
    const auto found = std::ranges::find_if(never, [&](const FaultThatNeverBegan& fault) {
      return fault.name == span.name && !(after && fault.by_time);
    });
    if (found != never.end()) never.erase(found);
  }
  return never;
}

}  // namespace cas::hils
