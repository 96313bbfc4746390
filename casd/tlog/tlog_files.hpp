// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <span>

#include "base/time/clock.hpp"

namespace cas::casd {

/// When a telemetry log goes on in another file.
struct TlogRotation {
  std::uint64_t max_bytes = 0;  ///< of one file; 0: any
  base::Duration max_age{};     ///< of one file; 0: any
  int keep = 0;                 ///< files of one recording that are kept; 0: all

  friend bool operator==(const TlogRotation&, const TlogRotation&) = default;
};

/// The files of one recording: FLIGHT.tlog, FLIGHT.1.tlog, FLIGHT.2.tlog ... Each is a log of its
/// own: no record lies across two of them.
class TlogFiles {
 public:
  TlogFiles() = default;
  ~TlogFiles() { close(); }
  TlogFiles(const TlogFiles&) = delete;
  TlogFiles& operator=(const TlogFiles&) = delete;

  /// Makes the first file; one of that name is written anew. @return false with errno set
  bool open(const std::filesystem::path& first, const TlogRotation& rotation, base::RunTime now);
  /// Writes whole records. @return false when a file cannot be made or takes no more
  bool write(std::span<const std::uint8_t> records, base::RunTime now);
  void close();

  const std::filesystem::path& current() const { return written_.back(); }

 private:
  bool make(const std::filesystem::path& file, bool anew, base::RunTime now);
  bool rotate(base::RunTime now);
  bool is_full(std::size_t next_bytes, base::RunTime now) const;

  std::filesystem::path first_;
  TlogRotation rotation_;
  int number_ = 0;
  int fd_ = -1;
  std::uint64_t size_ = 0;
  base::RunTime opened_{};
  std::deque<std::filesystem::path> written_;
};

/// FLIGHT.tlog where it is free, or the first of FLIGHT.1.tlog, FLIGHT.2.tlog ... that is.
std::filesystem::path free_tlog_name(const std::filesystem::path& wish);

}  // namespace cas::casd
