// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <span>
#include <string_view>

#include "base/os/result_file.hpp"

namespace cas::sim {

/// Writes rows of numbers as CSV: the shortest text that reads back as the same double, a dot
/// whatever the locale, no allocation per row.
class CsvWriter {
 public:
  CsvWriter() = default;
  /// Creates the file (and its folder) and writes the header. @throws base::ConfigError
  CsvWriter(base::ResultPlace place, std::string_view header);

  void row(std::span<const double> values);
  void row(std::initializer_list<double> values) { row({values.begin(), values.size()}); }
  /// @throws base::ConfigError when the data did not reach the disk
  void close();

 private:
  base::OpenFile file_;
  base::ResultPlace place_;
};

}  // namespace cas::sim
