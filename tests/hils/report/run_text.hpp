// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "hils/report/run_report.hpp"
#include "hils/report/summary_json.hpp"

namespace cas::hils::test {

/// A run of one vehicle.
inline RunResult run_of(const Measurement& figures, const Verdict& verdict) {
  return {.vehicles = {{.record = {}, .figures = figures, .verdict = verdict}}, .verdict = verdict};
}

/// What a terminal shows of it.
inline std::string run_text(const Measurement& figures, const Verdict& verdict,
                            bool beside_paper = false) {
  return write_text(run_lines(run_of(figures, verdict), beside_paper));
}

/// Its summary.json.
inline nlohmann::json run_summary(const Measurement& figures, const Verdict& verdict) {
  return nlohmann::json::parse(summary_json(run_of(figures, verdict)));
}

/// The vehicle's part of it.
inline nlohmann::json vehicle_summary(const Measurement& figures, const Verdict& verdict) {
  return run_summary(figures, verdict).at("vehicles").at(0);
}

}  // namespace cas::hils::test
