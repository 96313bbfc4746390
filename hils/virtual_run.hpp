// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hils/measurement.hpp"
#include "hils/run_request.hpp"

namespace cas::hils {

/// Flies a scenario in one process on the virtual clock: simulator, casd's router, queues and
/// ground station, the serial line and the controller as one discrete-event simulation. The same
/// scenario and seed give the same bytes of truth.csv and flight.tlog, on any machine.
///
/// @throws RunStopped when the user interrupts, base::ConfigError
RunRecord run_on_virtual_clock(const RunRequest& request);

}  // namespace cas::hils
