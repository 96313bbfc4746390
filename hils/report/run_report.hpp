// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "hils/measure/run_result.hpp"
#include "hils/report/document.hpp"
#include "hils/report/run_plots.hpp"

namespace cas::hils {

/// The report of a run: the verdict, then of each vehicle tables as [HILS] Tables 4 and 5, with its
/// rows below ours; on a page also limits, hops, curves and the configuration.
///
/// @param plots  of each vehicle, or none
/// @param config_files  files that are quoted in it, such as the scenario and generated
/// configurations
Document run_report(const RunResult& run, const std::vector<NamedPlots>& plots = {},
                    const std::vector<std::filesystem::path>& config_files = {});

}  // namespace cas::hils
