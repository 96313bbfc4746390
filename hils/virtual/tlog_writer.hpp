// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>

namespace cas::hils {

/// Writes a telemetry log: eight bytes (big-endian microseconds) and one packet, over and over.
class TlogWriter {
 public:
  /// @throws base::ConfigError
  explicit TlogWriter(const std::filesystem::path& file);
  void write(std::int64_t stamp_us, std::span<const std::uint8_t> packet);
  /// Writes out what is buffered. @throws base::ConfigError when something could not be written
  void close();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Closer> file_;
};

}  // namespace cas::hils
