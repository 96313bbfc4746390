// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/measure/tracking.hpp"

namespace cas::hils {

/// Finds a gap of 0.5 s or longer in the record of the true flight, from the begin of the first
/// step to the end of the last one. Incidents in a gap are not seen.
///
/// @param stages  the flight as it went, with the step under way
/// @return a sentence without a full stop; nullopt: the record has no gap
std::optional<std::string> record_hole(const std::vector<Stage>& stages,
                                       std::span<const PoseSample> truth);

}  // namespace cas::hils
