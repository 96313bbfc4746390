// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <vector>

namespace cas::casd {

/// Reads a telemetry log record by record, however long it is. Bytes that are no record are
/// skipped and counted.
class TlogReader {
 public:
  struct Record {
    std::uint64_t unix_us = 0;
    std::span<const std::uint8_t> packet;  ///< valid until the next call
  };

  /// @return false when it cannot be read
  bool open(const std::filesystem::path& file);
  /// Nothing at the end.
  std::optional<Record> next();
  std::uint64_t skipped_bytes() const { return skipped_; }

 private:
  bool refill();

  std::ifstream file_;
  std::vector<std::uint8_t> buffer_;
  std::size_t at_ = 0;
  std::uint64_t skipped_ = 0;
};

}  // namespace cas::casd
