// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "base/config/config.hpp"
#include "hils/flight/flight_step.hpp"

namespace cas::hils {

/// Checks that a condition compares `phase` with steps of the flight only, or with "done".
///
/// @param node  the condition: "altitude > 2 and phase == hold"
/// @throws base::ConfigError for another word, with the step that was meant where one is near
void check_phases(const base::ConfigNode& node, const std::vector<FlightStep>& steps);

/// Checks so the conditions `when` and `until` of a list of faults. @throws base::ConfigError
void check_fault_phases(const base::ConfigNode& faults, const std::vector<FlightStep>& steps);

}  // namespace cas::hils
