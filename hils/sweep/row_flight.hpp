// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "hils/run/run_request.hpp"
#include "hils/sweep/row_result.hpp"
#include "hils/sweep/sweep_folder.hpp"

namespace cas::hils {

/// Task of the process of one run.
struct RowTask {
  std::size_t row = 0;
  std::uint64_t seed = 1;
  Architecture architecture = Architecture::kDirect;
  std::filesystem::path scenario;      ///< the sweep's
  std::filesystem::path study_folder;  ///< values may name files in it
  std::vector<KeyValue> values{};
  std::vector<std::string> figures{};  ///< names of the columns that the run must give

  static RowTask of(const SweepFolder& sweep, std::size_t row);
  /// As JSON, for the process that flies it. @throws base::ConfigError
  void save(const std::filesystem::path& file) const;
  static RowTask load(const std::filesystem::path& file);
};

/// Exit code of a process whose machine let it down (a full disk): no verdict on the run.
inline constexpr int kExitMachine = 75;  // EX_TEMPFAIL of sysexits.h

/// Flies a task. @param folder  of its files, which is gone afterwards
using FlyTask = std::function<RowResult(const RowTask& task, const std::filesystem::path& folder)>;
/// On the virtual clock; stock firmware in software in its own time, as fast as it goes.
RowResult fly_alone(const RowTask& task, const std::filesystem::path& folder);

/// Flies the task of `folder`/task.json in this process and leaves `folder`/result.json.
///
/// @return exit code: 0 when there is a result, whatever it is; kExitMachine; kExitInterrupted
int fly_row(const std::filesystem::path& folder, const FlyTask& fly = fly_alone);

/// Written into a flight's folder by one that a board has stopped: why.
inline constexpr const char* kBoardSentence = "board.txt";

}  // namespace cas::hils
