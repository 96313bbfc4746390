// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "base/os/descriptor.hpp"
#include "hils/sweep/row_result.hpp"

namespace cas::hils {

/// The runs that one runner has flown, one line each. Each line is on the disk before the next
/// run's begins, so that a killed process or a power failure costs only the runs under way; a torn
/// last line is cut off when the journal is opened again.
class Journal {
 public:
  /// Opens it for this process alone, and makes it where there is none.
  /// @throws base::ConfigError also when another process has it
  explicit Journal(const std::filesystem::path& file);
  /// @throws base::ConfigError when it cannot be written; then the run counts as not flown
  void append(const RowResult& result);

 private:
  std::filesystem::path file_;
  base::Descriptor out_;
};

}  // namespace cas::hils
