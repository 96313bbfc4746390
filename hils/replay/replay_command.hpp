// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "base/cli/verb.hpp"
#include "hils/measure/run_result.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Leaves the record of a run in its folder, and replay.html where the page was built; one of an
/// earlier run goes in any case.
/// @return replay.html, or an empty path
/// @throws base::ConfigError
std::filesystem::path write_replay(const RunRequest& request, const RunResult& run);
/// The same with a record that is there already. @param record  JSON
std::filesystem::path write_replay(const std::filesystem::path& out, const std::string& record);

/// Adds `hils replay`, which makes the page of recorded runs and flight logs. Its run() throws
/// base::ConfigError.
base::cli::Verb add_replay(CLI::App& app);

}  // namespace cas::hils
