// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hils/measure/measurement.hpp"
#include "hils/programs/composition.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Faults of the emulated line cannot be played on a real port. @throws base::ConfigError
void refuse_emulator_faults(const RunRequest& request);

/// Checks the real controllers before the flight and prints the settings they need.
/// @throws RunStopped when one must not be flown
void check_devices(Supervisor& supervisor, const RunPaths& paths, const RunRequest& request);

/// Fills in the controller's part of the record. A real controller keeps no ledger: casd's port
/// counts as its end, and gaps between sequence numbers show losses beyond the port.
/// @param vehicle  whose record it is
void stand_in_for_controller(const RunPaths& paths, const VehiclePaths& vehicle, RunRecord& record);

/// The same without those gaps, from casd's ledgers in the record alone.
void stand_in_for_controller(RunRecord& record);

/// A stock autopilot stamps its controls by its own clock. Moves these stamps to simulated time, by
/// one constant offset, at both ends alike; does nothing when they echo the sensors'.
void align_control_stamps(RunRecord& record);

}  // namespace cas::hils
