// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cas::fcu {

/// Keeps "NAME VALUE" lines in a file that survives a torn write (base::write_file), with the one
/// before kept as FILE.bak; a last line tells whether it is whole.
class ParamFile {
 public:
  explicit ParamFile(std::filesystem::path file) : file_(std::move(file)) {}

  struct Entry {
    std::string name;
    double value = 0;
  };

  /// Reads "NAME VALUE" lines.
  static std::vector<Entry> parse(const std::string& lines);
  /// The newest intact save; empty without a file. @throws base::ConfigError when
  /// both the file and its backup are damaged
  std::vector<Entry> load() const;
  /// @return false when it could not be written (the old file is still there)
  bool save(const std::string& lines) const;

 private:
  std::filesystem::path file_;
};

}  // namespace cas::fcu
