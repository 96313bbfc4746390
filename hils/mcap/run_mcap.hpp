// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hils/measure/run_result.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Writes a run's recordings as one MCAP file for all of its vehicles, flight.mcap, for Foxglove:
/// truth, estimate, reference, motors and commands, shapes of vehicles and world, and every
/// MAVLink message of the flight log (docs/use/mcap.md). Times are simulated; the same record gives
/// the same bytes.
/// @throws base::ConfigError when a file of the run cannot be read, or the log not be written
void write_mcap(const RunRequest& request, const RunResult& run);

}  // namespace cas::hils
