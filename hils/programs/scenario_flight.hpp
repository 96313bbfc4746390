// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "hils/flight/flight_loop.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// The flight of a scenario of our controller, before its first look.
Flight flight_of(const Scenario& scenario);

/// Records how the flight of a vehicle went.
/// @param now  simulated time at the end of the run
void record_flight(const Flight& flight, std::size_t vehicle, base::SimTime now, RunRecord& record);

}  // namespace cas::hils
