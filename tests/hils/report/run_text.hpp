// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/report/run_report.hpp"

namespace cas::hils::test {

/// A run of one vehicle.
inline RunResult run_of(const Measurement& figures, const Verdict& verdict) {
  return {.vehicles = {{.record = {}, .figures = figures, .verdict = verdict}}, .verdict = verdict};
}

/// Its report on a terminal.
inline std::string run_text(const Measurement& figures, const Verdict& verdict) {
  return write_text(run_report(run_of(figures, verdict)));
}

}  // namespace cas::hils::test
