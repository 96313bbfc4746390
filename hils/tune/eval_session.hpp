// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>

namespace cas::hils {

/// How `hils eval` works.
struct EvalOptions {
  std::filesystem::path study;
  std::filesystem::path scratch;  ///< folder for the files of runs under way
  std::size_t jobs = 1;           ///< flights at once; with several, answers come as they are ready
  bool describe = false;          ///< describes requests, and ends
};

/// Reads requests from standard input, a line each, and answers each with one line on standard
/// output, until the input ends and all has been answered.
/// @return exit code @throws base::ConfigError where the study is wrong, RunStopped on SIGINT and
/// SIGTERM, std::runtime_error when standard output is closed
int eval_lines(const EvalOptions& options);

}  // namespace cas::hils
