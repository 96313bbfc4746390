// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "hils/firmware/firmware_figures.hpp"
#include "hils/firmware/firmware_scenario.hpp"
#include "hils/measure/measurement.hpp"

namespace cas::hils {

/// Window in which the machine is judged by the stream of a flight in HITL: the measured step, or
/// all steps of a flight that failed or of which too little is left; at most until a fault of the
/// bench begins or the firmware falls silent, because what is missing then is not the machine's.
/// nullopt: less than 1 s.
std::optional<StreamWindow> machine_window(const FirmwareFigures& figures);

/// Measures the HIL stream between the simulator and casd's serial port from the ledgers of both,
/// as that of a real controller (measure()); nullopt: there is nothing to measure.
/// @throws base::ConfigError when a ledger cannot be read
std::optional<Measurement> measure_hitl_stream(const FirmwareScenario& scenario,
                                               const FirmwarePlaces& places,
                                               const FirmwareFigures& figures);

}  // namespace cas::hils
