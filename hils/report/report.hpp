// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/measure/run_result.hpp"

namespace cas::hils {

/// Verdict and figures for people: tables as [HILS] Tables 4 and 5, with its rows below ours.
std::string text_report(const Measurement& figures, const Verdict& verdict);
/// Of a run: with several vehicles the verdict on all, a line for each, then the figures of each.
std::string text_report(const RunResult& run);

/// The same figures for programs, as JSON (docs/config.md names the fields).
std::string summary_json(const Measurement& figures, const Verdict& verdict);
/// Of a run: with several vehicles the common fields, then a list of the vehicles.
std::string summary_json(const RunResult& run);

/// PASSED, FAILED or INVALID.
std::string_view verdict_word(const Verdict& verdict);

/// The verdict for continuous integration, as JUnit XML: one case when every limit was kept, else
/// one for each that was missed, or for each reason why the run is not valid. Several vehicles have
/// a suite each.
std::string junit_report(const RunResult& run);
/// Report of a verdict without a Measurement. @param name  of the suite: "hils.px4_sitl"
std::string junit_report(const std::string& name, double wall_s, const Verdict& verdict);
/// Report of several vehicles, each with the name of its suite.
std::string junit_report(const std::vector<std::pair<std::string, Verdict>>& suites, double wall_s);

}  // namespace cas::hils
