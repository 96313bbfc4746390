// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/time/clock.hpp"
#include "casd/tlog/log_folder.hpp"

namespace cas::casd {

/// The limits of a folder of logs while logs are written: looks at the disk now and then, counts
/// what is written between, and deletes old logs where they may go (LogLimits::delete_oldest).
class LogRoom {
 public:
  explicit LogRoom(LogLimits limits = {}) : limits_(limits) {}

  const LogLimits& limits() const { return limits_; }
  /// Why `more` bytes must not be written, as a clause; nullopt: they may.
  /// @param current  a file that stays
  std::optional<std::string> lack(const LogFolder& folder, std::uint64_t more,
                                  const std::string& current, base::RunTime now);
  /// The folder has so many bytes more.
  void wrote(std::uint64_t bytes);
  /// Files came or went: the next lack() looks at the disk.
  void look_again();

 private:
  LogLimits limits_;
  LogSpace space_;
  std::optional<base::RunTime> free_read_at_;     ///< when space_.free_bytes was read
  std::optional<base::RunTime> used_counted_at_;  ///< when space_.used_bytes was counted
};

}  // namespace cas::casd
