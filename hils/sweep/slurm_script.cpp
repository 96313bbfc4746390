// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/slurm_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace cas::hils {

namespace {

constexpr std::size_t kMostChunks = 1000;

/// In single quotes for a POSIX shell.
std::string in_quotes(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
    } else {
      result += c;
    }
  }
  return result + "'";
}

/// A name for a job: characters that a directive cannot hold become '_'.
std::string plain(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '.'; }, '_');
  return text;
}

}  // namespace

std::size_t slurm_chunks(std::size_t rows, double seconds_a_run, std::size_t jobs,
                         double chunk_minutes) {
  const double all_s = static_cast<double>(rows) * seconds_a_run / static_cast<double>(jobs);
  const double chunks = std::ceil(all_s / (chunk_minutes * 60));
  const std::size_t most = std::min(rows, kMostChunks);
  if (!(chunks < static_cast<double>(most))) return std::max<std::size_t>(most, 1);
  return std::max<std::size_t>(static_cast<std::size_t>(chunks), 1);
}

std::string slurm_ranges(const std::vector<std::size_t>& numbers) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t end = i + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    text += fmt::format("{}{}", text.empty() ? "" : ",", numbers[i]);
    if (end - i > 1) text += fmt::format("-{}", numbers[end - 1]);
    i = end;
  }
  return text;
}

std::string slurm_script(const SlurmArray& array) {
  std::string text = "#!/bin/sh\n";
  text += fmt::format("#SBATCH --job-name={}\n", plain("sweep-" + array.name));
  text += fmt::format("#SBATCH --array={}\n", slurm_ranges(array.missing));
  text += fmt::format("#SBATCH --cpus-per-task={}\n", array.jobs);
  text += fmt::format("#SBATCH --time={}\n", array.minutes);
  text += fmt::format("#SBATCH --output=\"{}/%A_%a.log\"\n", array.logs.string());
  if (!array.partition.empty()) text += fmt::format("#SBATCH --partition={}\n", array.partition);
  text += fmt::format(
      "exec {} sweep run {} --chunk \"$SLURM_ARRAY_TASK_ID/{}\" --jobs {} "
      "--scratch \"${{TMPDIR:-/tmp}}\"\n",
      in_quotes(array.program.string()), in_quotes(array.sweep.string()), array.chunks, array.jobs);
  return text;
}

}  // namespace cas::hils
