// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace cas::hils {

/// A job array of Slurm that flies a sweep, one chunk a task.
struct SlurmArray {
  std::string name;                    ///< of the job
  std::filesystem::path program;       ///< hils
  std::filesystem::path sweep;         ///< folder, seen by all nodes
  std::filesystem::path logs;          ///< folder of the tasks' output
  std::size_t chunks = 1;              ///< that the sweep is cut into
  std::vector<std::size_t> missing{};  ///< chunks that are submitted, ascending
  std::size_t jobs = 1;                ///< processors of a task
  std::size_t minutes = 60;            ///< time limit of a task
  std::string partition{};             ///< empty: the cluster's default
};

/// How many chunks `rows` runs are cut into, so that each takes about `chunk_minutes`: at least 1,
/// at most one a row and 1000 (Slurm's default MaxArraySize is 1001).
std::size_t slurm_chunks(std::size_t rows, double seconds_a_run, std::size_t jobs,
                         double chunk_minutes);

/// "1-3,7": ascending numbers as Slurm takes them.
std::string slurm_ranges(const std::vector<std::size_t>& numbers);

/// The batch script.
std::string slurm_script(const SlurmArray& array);

}  // namespace cas::hils
