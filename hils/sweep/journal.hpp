// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "base/os/descriptor.hpp"
#include "hils/sweep/row_result.hpp"

namespace cas::hils {

/// Finished runs of one runner, a line for each run. Each line is on the disk before the next run
/// begins, so that a killed process or a power failure loses only the current runs; a torn last
/// line is removed when the journal is opened again.
class Journal {
 public:
  /// Opens it for this process only, and creates it if missing. @throws base::ConfigError also if
  /// another process has it
  explicit Journal(const std::filesystem::path& file);
  /// @throws base::ConfigError when it cannot be written; then the run counts as not flown
  void append(const RowResult& result);

 private:
  std::filesystem::path file_;
  base::Descriptor out_;
};

}  // namespace cas::hils
