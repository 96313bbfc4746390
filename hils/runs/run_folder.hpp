// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace cas::hils {

/// Whether `hils run` has left its summary in a folder.
bool is_run_folder(const std::filesystem::path& folder);

/// summary.json of a run's folder.
/// @throws base::ConfigError when the folder holds no run, or its summary cannot be read
nlohmann::json read_summary(const std::filesystem::path& folder);

/// The record of its replay; null where it has none.
/// @throws base::ConfigError when it cannot be read
nlohmann::json read_record(const std::filesystem::path& folder);

/// When the run ended: seconds since 1970, of the summary's file.
std::int64_t end_of_run(const std::filesystem::path& folder);

}  // namespace cas::hils
