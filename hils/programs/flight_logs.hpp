// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

namespace cas::hils {

/// The flight logs of a run in which casd is killed and started again: each casd writes a new file
/// of the same name, and in the end they are joined.
class FlightLogs {
 public:
  /// @param log  that casd writes
  /// @param folder  where those of ended casds wait
  FlightLogs(std::filesystem::path log, std::filesystem::path folder)
      : log_(std::move(log)), folder_(std::move(folder)) {}

  /// To be called after casd has been killed: keeps its log from being overwritten.
  void set_aside();
  /// To be called after the last casd has ended.
  /// @throws base::ConfigError when a log cannot be read or written
  void join();

 private:
  std::filesystem::path log_;
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> earlier_;
};

}  // namespace cas::hils
