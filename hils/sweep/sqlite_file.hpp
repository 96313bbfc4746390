// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "hils/sweep/sweep_view.hpp"

namespace cas::hils {

/// Writes a sweep as one SQLite file, whole or not at all: table `runs` (a row a run, as in
/// results.csv), table `machine` (cost and host of a run), table `study` (key, value).
/// @throws base::ConfigError when it cannot be written
void write_sqlite(const SweepView& view, const std::filesystem::path& file);

}  // namespace cas::hils
