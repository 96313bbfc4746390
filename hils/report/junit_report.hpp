// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "hils/measure/judgement.hpp"
#include "hils/measure/run_result.hpp"

namespace cas::hils {

/// The verdict for continuous integration, as JUnit XML: one case when every limit was kept, else
/// one for each that was missed, or for each reason why the run is not valid. Several vehicles have
/// a suite each.
std::string junit_report(const RunResult& run);
/// Report of a verdict without a Measurement. @param name  of the suite: "hils.px4_sitl"
std::string junit_report(const std::string& name, double wall_s, const Verdict& verdict);
/// Report of several vehicles, each with the name of its suite.
std::string junit_report(const std::vector<std::pair<std::string, Verdict>>& suites, double wall_s);

}  // namespace cas::hils
