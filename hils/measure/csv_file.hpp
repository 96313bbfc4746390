// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace cas::hils {

/// Reads a CSV file of a run, which the recorder wrote: one line of names, then rows of numbers.
///
/// @code
///   CsvFile csv(out / "sensors/imu.csv");
///   for (std::span<const double> row = csv.next(4); !row.empty(); row = csv.next(4)) use(row);
/// @endcode
class CsvFile {
 public:
  /// A file that is not there has no header and no rows.
  /// @throws base::ConfigError when the header cannot be read
  explicit CsvFile(std::filesystem::path file);

  bool is_there() const { return is_there_; }
  /// The line of names.
  const std::string& header() const { return header_; }

  /// The next row, which stays valid until the next call; empty at the end.
  /// @param columns  how many numbers a row has at least
  /// @throws base::ConfigError naming file and line when the line is no such row, or when reading
  ///         fails before the end of the file
  std::span<const double> next(std::size_t columns);

 private:
  bool read_line();
  bool parse_line();

  std::filesystem::path file_;
  std::ifstream in_;
  bool is_there_;
  std::string header_;
  std::string line_;
  std::vector<double> row_;
  int number_ = 1;  ///< of the line
};

}  // namespace cas::hils
