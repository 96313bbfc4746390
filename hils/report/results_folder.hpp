// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hils/measure/run_result.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Writes summary.json, junit.xml, report.html and plots/*.svg of a run into its folder; with
/// several vehicles each has a folder of its own below plots. @throws base::ConfigError
void write_results(const RunRequest& request, const RunResult& run);

}  // namespace cas::hils
