// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/measure/tracking.hpp"

namespace cas::hils {

/// Where a record of the true flight has nothing for 0.5 s or longer, from the begin of the first
/// step to the end of the last one. Incidents in it are not seen.
///
/// @param stages  the flight as it went, with the step under way
/// @return a sentence without a full stop; empty: it is whole
std::string record_hole(const std::vector<Stage>& stages, std::span<const PoseSample> truth);

}  // namespace cas::hils
