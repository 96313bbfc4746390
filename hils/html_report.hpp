// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "hils/judgement.hpp"
#include "hils/measurement.hpp"
#include "hils/plot.hpp"

namespace cas::hils {

/// The report of one run as a self-contained HTML file: verdict, tables, curves, configuration.
///
/// @param config_files  files that are quoted in it, such as the scenario and what was made of it
std::string html_report(const Measurement& figures, const Verdict& verdict,
                        const std::vector<std::pair<std::string, Plot>>& plots,
                        const std::vector<std::filesystem::path>& config_files);

/// The verdict for continuous integration, as JUnit XML: one case for validity, one for the flight
/// and one for each limit that was missed.
std::string junit_report(const Measurement& figures, const Verdict& verdict);

}  // namespace cas::hils
