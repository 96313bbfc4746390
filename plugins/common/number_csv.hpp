// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <sstream>
#include <string>

namespace cas::sim {

/// Reads a CSV file that a user has written: one line of names, then lines of as many numbers as
/// there are names. Empty lines count for nothing.
///
/// @code
///   NumberCsv csv(file, "wind grid", kMostBytes, "x_m,y_m,z_m,u_m_s,v_m_s,w_m_s");
///   for (std::array<double, 6> row; csv.next(row);) use(row);
/// @endcode
class NumberCsv {
 public:
  /// @param kind    what the file is, for errors
  /// @param header  the line of names that it must begin with
  /// @throws base::ConfigError when it cannot be read, is larger or begins with another line
  NumberCsv(const std::filesystem::path& file, const std::string& kind, std::size_t most_bytes,
            const std::string& header);

  /// Reads the next line. @return false at the end of the file
  /// @throws base::ConfigError naming file and line when it has not exactly these many finite
  ///         numbers
  bool next(std::span<double> values);

  /// @throws base::ConfigError with the file and the line that was read last
  [[noreturn]] void fail(const std::string& sentence) const;

 private:
  bool read_line();

  std::filesystem::path file_;
  std::istringstream stream_;
  std::string text_;
  int line_ = 0;
};

}  // namespace cas::sim
