// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/report/document.hpp"
#include "hils/timing/timing_verdict.hpp"

namespace cas::hils {

/// A measurement and its setup.
struct TimingReport {
  std::string device;
  unsigned baud = 0;
  bool is_pty = false;  ///< a pseudo-terminal, where no baud rate applies
  LineDemand demand{};
  LineFigures figures{};
  TimingVerdict verdict{};
};

/// Verdict, round trips, throughput and loads.
Document timing_report(const TimingReport& report);
/// The same figures as a JSON object, units in the names.
std::string timing_json(const TimingReport& report);

}  // namespace cas::hils
