// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/row_again.hpp"

#include <fmt/format.h>

#include <deque>
#include <filesystem>
#include <memory>
#include <utility>

#include "base/os/result_file.hpp"
#include "base/time/clock.hpp"
#include "hils/programs/child_process.hpp"
#include "hils/sweep/flight_digest.hpp"
#include "hils/sweep/sweep_runner.hpp"

namespace cas::hils {

namespace fs = std::filesystem;

namespace {

fs::path report_of(const SweepFolder& sweep, std::size_t row) {
  return sweep.again(row) / "report.html";
}

std::unique_ptr<ChildProcess> start_again(const SweepFolder& sweep, std::size_t row) {
  fmt::print(stderr, "row {} is flown again for its report\n", row);
  write_row_again(sweep, row);
  std::vector<std::string> command = command_again(sweep, row);
  command.front() = kSameProgram;
  return std::make_unique<ChildProcess>(
      ChildProcess::Options{.name = "the process of a run",
                            .arguments = std::move(command),
                            .log_file = sweep.again(row) / "log.txt"});
}

}  // namespace

void write_row_again(const SweepFolder& sweep, std::size_t row) {
  refuse_rows_of_boards(sweep);
  base::make_result_folder({sweep.path, sweep.again(row)});
  write_scenario(sweep.scenario(), sweep.values_of(sweep.row(row)), sweep.study_folder,
                 sweep.again(row));
}

std::vector<std::string> command_again(const SweepFolder& sweep, std::size_t row) {
  const fs::path folder = sweep.again(row);
  std::vector<std::string> words{own_program().string(), "run",
                                 (folder / "scenario.yaml").string()};
  if (Scenario::load(sweep.scenario()).firmware) {
    words.emplace_back("--lockstep");
  } else {
    words.insert(words.end(), {"--architecture", std::string(to_string(sweep.study.architecture))});
    if (sweep.study.architecture != Architecture::kDirect) words.emplace_back("--virtual");
  }
  words.insert(words.end(),
               {"--seed", std::to_string(sweep.row(row).seed), "--out", folder.string()});
  return words;
}

std::vector<std::size_t> fly_again(const SweepFolder& sweep, const std::vector<std::size_t>& rows,
                                   std::size_t jobs) {
  const base::Duration patience = base::from_seconds(sweep.study.deadline_s);
  std::deque<std::unique_ptr<ChildProcess>> under_way;
  for (const std::size_t row : rows) {
    if (fs::exists(report_of(sweep, row))) continue;
    if (under_way.size() >= jobs) {
      under_way.front()->wait_exit(patience);
      under_way.pop_front();
    }
    under_way.push_back(start_again(sweep, row));
  }
  for (; !under_way.empty(); under_way.pop_front()) under_way.front()->wait_exit(patience);
  std::vector<std::size_t> flown;
  for (const std::size_t row : rows) {
    if (fs::exists(report_of(sweep, row))) flown.push_back(row);
  }
  return flown;
}

bool flew_otherwise(const SweepFolder& sweep, const RowResult& result) {
  const fs::path truth = sweep.again(result.row) / "truth.csv";
  return fs::exists(truth) && sha256_of_files({truth}) != result.truth_sha256;
}

}  // namespace cas::hils
