// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "hils/flight/flight_facts.hpp"
#include "hils/flight/flight_step.hpp"

namespace cas::hils {

/// A method of casd's command port and its parameters.
using Call = std::pair<std::string, nlohmann::json>;

/// What casd is asked for a step of the flight, one after the other.
std::vector<Call> to_calls(const FlightStep& step);

/// Motion of a vehicle in sim.status, whose axes are W's: x east, y north.
Motion to_motion(const nlohmann::json& vehicle);

}  // namespace cas::hils
