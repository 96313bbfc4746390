// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "hils/sweep/sweep_view.hpp"

namespace cas::hils {

/// Writes a sweep as one SQLite file, atomically: table `runs` (a row per run, as in results.csv),
/// table `machine` (cost and host of a run), table `study` (key, value). @throws base::ConfigError
/// if it cannot be written
void write_sqlite(const SweepView& view, const std::filesystem::path& file);

}  // namespace cas::hils
