// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "hils/sweep/sweep_folder.hpp"

namespace cas::hils {

/// How a part of a sweep is flown.
struct SweepRunOptions {
  const char* verb = "sweep";  ///< of its progress
  Chunk chunk{};
  std::size_t jobs = 1;             ///< processes at once
  std::filesystem::path scratch{};  ///< files of runs under way; empty: in the sweep's folder
  bool retry = false;               ///< flies runs that died or hung once more
  double after_s = 0;               ///< extra time for a run beyond its study's deadline
  bool on_boards = false;           ///< as `controllers.json` in the sweep's folder says
  bool keeps_flights = false;       ///< each leaves its report and replay: `hils campaign --fly`
};
/// File in a sweep's folder that says with which boards the rows are flown, and that they are.
inline constexpr const char* kControllersFile = "controllers.json";

/// Result of it.
struct SweepRunResult {
  std::size_t rows = 0;       ///< of the chunk
  std::size_t flown = 0;      ///< now; the others had been flown before
  std::size_t unjudged = 0;   ///< of all rows of the chunk: without a verdict
  std::string first_cause{};  ///< of the first of them
  bool all_refused = false;   ///< no run of the chunk was possible
};

/// How many rows are flown at once where nobody says: as many as there are processors; of stock
/// firmware one, because PX4 holds a lock of its instance in /tmp, which all flights share.
std::size_t usual_jobs(const SweepFolder& sweep);

/// @throws base::ConfigError where the rows of a folder are flown with boards
void refuse_rows_of_boards(const SweepFolder& sweep);

/// Flies the rows of a chunk that have not been flown, each in a process of its own, and writes the
/// chunk's CSV files when all are done. A run that dies or hangs costs its own row.
/// @throws RunStopped on SIGINT and SIGTERM, BoardError when a board stops it, base::ConfigError
/// when files cannot be written, or the rows are to be flown with boards and these are not
SweepRunResult run_sweep(const SweepFolder& sweep, const SweepRunOptions& options);

}  // namespace cas::hils
