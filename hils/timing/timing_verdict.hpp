// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hils/measure/judgement.hpp"
#include "hils/timing/line_demand.hpp"
#include "hils/timing/line_probe.hpp"

namespace cas::hils {

/// Whether a line carries a HIL run.
struct TimingVerdict {
  ExitCode code = kExitPassed;  ///< kExitLimitsMissed: it does not; kExitInvalid: unknown
  std::string sentence;         ///< "500 Hz HIL_SENSOR (...) fits with 31 % to spare"
  double spare = 0;  ///< share of the fuller direction that is free; negative: how much is missing
  std::optional<double> fitting_sensor_hz{};  ///< measured, where the wanted rate does not fit
  std::vector<std::string> notes{};           ///< further remarks, a sentence each
};

/// Judges a whole measurement. The demand fits where both directions have room for it in 98 % of
/// the measured throughput, and the line kept up under its load. A line that carries the bytes and
/// failed under the load on a machine that was late itself has no verdict. Pure.
TimingVerdict judge_line(const LineFigures& figures, const LineDemand& demand);

/// What a UART would have to spare where a pseudo-terminal was measured, as a sentence. Pure.
/// @param baud  of the UART
std::string uart_note(const LineFigures& figures, const LineDemand& demand, unsigned baud);

}  // namespace cas::hils
