// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "base/time/clock.hpp"
#include "casd/tlog/log_room.hpp"
#include "casd/tlog/tlog_files.hpp"

namespace cas::casd {

/// A recording. When the disk is full or gone, or a limit is reached, it pauses, says so once in
/// the log, and goes on by itself once there is room. One thread at a time.
class TlogRecording {
 public:
  struct Options {
    TlogFiles::Options files;
    LogLimits limits;
    /// Also waits when the first file cannot be made for another reason than lack of room.
    bool insist = false;
  };

  /// How often a paused recording looks whether it may go on.
  static constexpr base::Duration kRetryPeriod = std::chrono::seconds(1);
  /// Least room below a limit before it goes on, so that it does not stop again with the next
  /// packet.
  static constexpr std::size_t kRoomToGoOn = 256 * 1024;

  /// @throws base::ConfigError when the first file cannot be made
  void begin(Options options, base::RunTime now);
  /// Writes as many of these whole records as the disk takes.
  /// @return how many packets are in the files now; those that are not are lost
  std::size_t write(std::span<const std::uint8_t> records, base::RunTime now);
  /// Looks whether somebody has deleted the file that is written; another one follows it.
  /// @return packets that were in it
  std::uint64_t leave_deleted();
  void end() { files_.close(); }

  /// Why it pauses, as a clause; nullopt: it does not. Holds until packets are in a file again.
  const std::optional<std::string>& pause() const { return pause_; }
  /// Since when; meaningful while it is paused.
  base::RunTime paused_since() const { return paused_since_; }
  std::filesystem::path file() const { return files_.current(); }
  std::uint64_t bytes() const { return bytes_; }

 private:
  bool may_write(std::size_t more, base::RunTime now);
  void pause(std::string why, base::RunTime now);
  void go_on();

  Options options_;
  TlogFiles files_;
  std::optional<std::string> pause_;
  base::RunTime paused_since_{};
  std::optional<base::RunTime> retry_at_;
  std::uint64_t bytes_ = 0;
  std::uint64_t lost_ = 0;  ///< packets since the pause began
  LogRoom room_;
};

}  // namespace cas::casd
