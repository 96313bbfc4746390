// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "hils/sweep/sweep_folder.hpp"

namespace cas::hils {

/// A path as a shell takes it.
std::string shell_word(const std::string& text);

/// The user's options for a job array.
struct JobArrayOptions {
  std::string partition;
  std::size_t chunks = 0;  ///< 0: by chunk_minutes
  double chunk_minutes = 10;
  double run_seconds = 0;  ///< 0: as measured, or 1
  std::size_t jobs = 1;    ///< processors of a task
};

/// Writes the batch script for the missing runs of a sweep and submits it. Prints the result on
/// standard output.
/// @throws base::ConfigError, std::runtime_error when there is no Slurm, or it refuses the array
void submit_job_array(const SweepFolder& sweep, const JobArrayOptions& options);

}  // namespace cas::hils
