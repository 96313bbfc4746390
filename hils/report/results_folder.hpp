// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "hils/measure/run_result.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Makes the folder that --out names, which this user can write in; refuses a symlink of
/// another user on the way to it, and a folder of another user that everybody may write into.
/// @throws base::ConfigError
void make_results_folder(const std::filesystem::path& folder);

/// Makes the first of `parent`/NAME, NAME-2, NAME-3, ... that does not exist, and `parent` if need
/// be. Two programs never get the same one. @throws base::ConfigError
std::filesystem::path make_next_folder(const std::filesystem::path& parent,
                                       const std::string& name);

/// Removes what an earlier run left in a folder, so that no file there is of another run than its
/// neighbour, and a run that dies leaves no verdict. What no run writes stays, also in folders of a
/// run; follows no symlink. @throws base::ConfigError
void clear_earlier_run(const std::filesystem::path& folder);

/// Writes summary.json, junit.xml, report.html and plots/*.svg of a run into its folder; with
/// several vehicles each has a folder of its own below plots. @throws base::ConfigError
void write_results(const RunRequest& request, const RunResult& run);

}  // namespace cas::hils
