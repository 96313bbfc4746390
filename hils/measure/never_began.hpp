// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hils/flight/bench_fault.hpp"

namespace cas::hils {

/// A fault of the scenario that did not begin in the whole run.
struct FaultThatNeverBegan {
  std::string name;
  bool by_time = false;  ///< it has a time, not a condition
};

/// Faults that a scenario has for one vehicle less those that began. Faults of the same name are
/// counted. One with a time did not begin in the flight when it came after the last step: programs
/// run on for a while.
///
/// @param stages  the flight as it went
std::vector<FaultThatNeverBegan> faults_that_never_began(
    const ScenarioFaults& faults, std::size_t vehicle,
    const std::vector<BenchFaultScript::Span>& begun, const std::vector<Stage>& stages);

}  // namespace cas::hils
