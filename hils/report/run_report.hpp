// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "hils/measure/run_result.hpp"
#include "hils/report/document.hpp"
#include "hils/report/run_plots.hpp"

namespace cas::hils {

/// What the page of a run shows besides its figures.
struct RunReportParts {
  bool beside_paper = false;        ///< rows of [HILS] Tables 4 and 5 below ours
  std::vector<NamedPlots> plots{};  ///< of each vehicle, or none
  /// Files that are quoted, such as the scenario and generated configurations.
  std::vector<std::filesystem::path> config_files{};
};

/// The page of a run: the verdict, its limits, then of each vehicle communication, hops, flight and
/// curves, and the configuration.
Document run_report(const RunResult& run, const RunReportParts& parts = {});

/// The same for a terminal, where the last lines are read first: figures of each vehicle, limits
/// with their margins, and the verdict at the end.
/// @param beside_paper  rows of [HILS] Tables 4 and 5 below ours
Document run_lines(const RunResult& run, bool beside_paper = false);

}  // namespace cas::hils
