// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "hils/measure/run_record.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Flies a scenario in one process on the virtual clock: simulator, casd's router, queues and
/// ground station, the serial line and the controller as one discrete-event simulation. The same
/// scenario and seed give the same bytes of truth.csv and flight.tlog, on any machine.
///
/// @return one record for each vehicle, in the order of the scenario
/// @throws RunStopped when the user interrupts, base::ConfigError
std::vector<RunRecord> run_on_virtual_clock(const RunRequest& request);

}  // namespace cas::hils
