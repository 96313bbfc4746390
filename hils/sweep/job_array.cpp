// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/job_array.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/programs/child_process.hpp"
#include "hils/sweep/slurm_script.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

constexpr double kUsualRunSeconds = 1;

/// Chunks of `n` in which a row has not been flown.
std::vector<std::size_t> missing_chunks(const SweepFolder& sweep, std::size_t n) {
  std::vector<bool> done(sweep.table.rows.size(), false);
  sweep.for_each_result([&](RowResult&& result) { done[result.row - 1] = true; });
  std::vector<std::size_t> missing;
  for (std::size_t k = 1; k <= n; ++k) {
    const auto [first, last] = rows_of_chunk(done.size(), k, n);
    for (std::size_t row = first; row < last; ++row) {
      if (done[row - 1]) continue;
      missing.push_back(k);
      break;
    }
  }
  return missing;
}

double measured_run_seconds(const SweepFolder& sweep) {
  double wall_s = 0;
  std::size_t runs = 0;
  sweep.for_each_result([&](RowResult&& result) {
    wall_s += result.machine.wall_s;
    ++runs;
  });
  return runs > 0 ? wall_s / static_cast<double>(runs) : kUsualRunSeconds;
}

/// Says how many chunks the first job array has.
fs::path chunks_file(const SweepFolder& sweep) { return sweep.path / "slurm" / "chunks.txt"; }

/// How many chunks a job array has: those of the first one, whose jobs may still run. @param asked
/// by the user; 0: `usual`
std::size_t chunks_of_array(const SweepFolder& sweep, std::size_t asked, std::size_t usual) {
  const fs::path file = chunks_file(sweep);
  const std::size_t rows = sweep.table.rows.size();
  if (!fs::exists(file)) return std::min(asked > 0 ? asked : usual, rows);
  std::size_t chunks = 0;
  std::istringstream(text_of_file(file)) >> chunks;
  if (chunks < 1 || chunks > rows) {
    throw base::ConfigError(
        fmt::format("{}: is a number of chunks from 1 to {}", file.string(), rows));
  }
  if (asked > 0 && std::min(asked, rows) != chunks) {
    throw base::ConfigError(
        fmt::format("{}: sweep.sbatch was written for {} chunks, whose jobs may still run; leave "
                    "out --chunks, or remove this file when none does",
                    file.string(), chunks));
  }
  return chunks;
}

/// The program of that name on PATH; empty where there is none.
fs::path on_path(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (folder.empty()) continue;
    const fs::path file = fs::path(folder) / name;
    if (::access(file.c_str(), X_OK) == 0 && !fs::is_directory(file)) return file;
  }
  return {};
}

/// @throws std::runtime_error when Slurm refuses the array
void submit(const SweepFolder& sweep, SlurmArray array) {
  if (array.missing.empty()) {
    fmt::print("All runs have been flown; 'hils sweep collect {}' is next.\n", sweep.path.string());
    return;
  }
  for (const std::string& text : {array.logs.string(), array.partition}) {
    if (text.find_first_of("\"\\%\n\r") != std::string::npos) {
      throw base::ConfigError("'" + text + "': a job array takes no \", \\, % or line break here");
    }
  }
  base::make_result_folder({sweep.path, array.logs});
  const bool is_first = !fs::exists(chunks_file(sweep));
  if (is_first) {
    base::write_result({sweep.path, chunks_file(sweep)}, fmt::format("{}\n", array.chunks),
                       base::Durability::kDisk);
  }
  const fs::path script = sweep.path / "slurm" / "sweep.sbatch";
  base::write_result({sweep.path, script}, slurm_script(array), base::Durability::kDisk);
  fmt::print("{}: {} of {} chunks\n", script.string(), array.missing.size(), array.chunks);
  const fs::path sbatch = on_path("sbatch");
  if (sbatch.empty()) {
    throw std::runtime_error(
        fmt::format("there is no sbatch on this machine; sweep.sbatch was written for {} chunks, "
                    "where there is one: sbatch {}",
                    array.chunks, shell_word(script.string())));
  }
  const fs::path log_file = sweep.path / "slurm" / "sbatch.txt";
  ChildProcess process(
      {.name = "sbatch", .arguments = {sbatch.string(), script.string()}, .log_file = log_file});
  constexpr base::Duration kPatience = std::chrono::minutes(2);
  const std::optional<ExitStatus>& end = process.wait_exit(kPatience);
  const std::string said = text_of_file(log_file);
  if (!end || end->code != 0) {
    if (end && is_first) fs::remove(chunks_file(sweep));  // no job has these chunks
    throw std::runtime_error(
        fmt::format("sbatch {}: {}", end ? end->words : "does not answer", said));
  }
  fmt::print("{}", said);
}

}  // namespace

std::string shell_word(const std::string& text) {
  const bool plain = std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("/._-+:,=@").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (plain && !text.empty()) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

void submit_job_array(const SweepFolder& sweep, const JobArrayOptions& options) {
  const double seconds =
      options.run_seconds > 0 ? options.run_seconds : measured_run_seconds(sweep);
  const std::size_t rows = sweep.table.rows.size();
  const std::size_t chunks = chunks_of_array(
      sweep, options.chunks, slurm_chunks(rows, seconds, options.jobs, options.chunk_minutes));
  const double chunk_s =
      seconds * std::ceil(static_cast<double>(rows) / static_cast<double>(chunks * options.jobs));
  submit(sweep, {.name = sweep.study.name,
                 .program = own_program(),
                 .sweep = sweep.path,
                 .logs = sweep.path / "slurm",
                 .chunks = chunks,
                 .missing = missing_chunks(sweep, chunks),
                 .jobs = options.jobs,
                 // Four times the expected time, for slower nodes.
                 .minutes = static_cast<std::size_t>(std::ceil(chunk_s / 15)) + 5,
                 .partition = options.partition});
}

}  // namespace cas::hils
