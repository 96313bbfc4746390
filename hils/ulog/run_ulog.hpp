// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hils/measure/run_record.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Writes one vehicle's recordings in the form of PX4's logger: flight.ulg, for Flight Review and
/// PlotJuggler. Truth and sensors come from the simulator's CSV files, estimates, setpoints,
/// actuators and state from the flight log, the parameters of an emulated controller from its
/// configuration. Messages are in order of simulated time; the same record gives the same bytes.
///
/// @param vehicle  its place in the scenario
/// @throws base::ConfigError when a file of the run cannot be read, or the log not be written
void write_ulog(const RunRequest& request, const RunRecord& record, std::size_t vehicle);

}  // namespace cas::hils
