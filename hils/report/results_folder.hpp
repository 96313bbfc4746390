// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "hils/measure/run_result.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Makes the folder that --out names, which this user can write in; refuses another user's symlink,
/// and a folder of another user that everybody may write into. @throws base::ConfigError
void make_results_folder(const std::filesystem::path& folder);

/// Removes the verdict of an earlier run from a folder, and the report, the replay and the figures
/// of the simulator that tell of it: a run that dies leaves none. @throws base::ConfigError
void remove_verdict(const std::filesystem::path& folder);

/// Writes summary.json, junit.xml, report.html and plots/*.svg of a run into its folder; with
/// several vehicles each has a folder of its own below plots. @throws base::ConfigError
void write_results(const RunRequest& request, const RunResult& run);

}  // namespace cas::hils
