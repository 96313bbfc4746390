// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <span>
#include <string_view>

namespace cas::sim {

/// Writes rows of numbers as CSV: the shortest text that reads back as the same double, a dot
/// whatever the locale, no allocation per row.
class CsvWriter {
 public:
  CsvWriter() = default;
  /// Creates the file (and its folder) and writes the header. @throws base::ConfigError
  CsvWriter(const std::filesystem::path& file, std::string_view header);

  void row(std::span<const double> values);
  void row(std::initializer_list<double> values) { row({values.begin(), values.size()}); }
  /// @throws base::ConfigError when the data did not reach the disk
  void close();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::unique_ptr<std::FILE, CloseFile> file_;
  std::filesystem::path path_;
};

}  // namespace cas::sim
