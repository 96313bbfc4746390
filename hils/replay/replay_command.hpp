// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "hils/measure/run_result.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Writes the record of a run into its folder, and replay.html if the page was built; removes those
/// of an earlier run.
/// @return replay.html, or an empty path
/// @throws base::ConfigError
std::filesystem::path write_replay(const RunRequest& request, const RunResult& run);
/// The same with a record that exists already. @param record  JSON
std::filesystem::path write_replay(const std::filesystem::path& out, const std::string& record);

}  // namespace cas::hils
