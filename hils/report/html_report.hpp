// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hils/measure/run_result.hpp"
#include "hils/report/run_plots.hpp"

namespace cas::hils {

/// The report of a run as a self-contained HTML file: the verdict, then of each vehicle tables and
/// curves, then the configuration.
///
/// @param plots  of each vehicle
/// @param config_files  files that are quoted in it, such as the scenario and generated
/// configurations
std::string html_report(const RunResult& run, const std::vector<NamedPlots>& plots,
                        const std::vector<std::filesystem::path>& config_files);

}  // namespace cas::hils
