// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "base/os/descriptor.hpp"
#include "base/read_file.hpp"
#include "base/time/clock.hpp"
#include "casd/tlog/log_folder.hpp"
#include "mavlink_gen/services/tlog.hpp"
#include "mavlink_gen/services/tlog_clock.hpp"

namespace cas::casd {

using mav::services::append_tlog_record;

/// When a telemetry log continues in a new file.
struct TlogRotation {
  std::uint64_t max_bytes = 0;  ///< of one file; 0: any
  base::Duration max_age{};     ///< of one file; 0: any
  int keep = 0;                 ///< files of one recording that are kept; 0: all

  friend bool operator==(const TlogRotation&, const TlogRotation&) = default;
};

/// Packets in whole records that lie end to end. Bytes that are no record count as one.
std::size_t count_tlog_records(std::span<const std::uint8_t> records);

/// The files of one recording: NAME.tlog, NAME.1.tlog, NAME.2.tlog ... in one folder. Each is a log
/// of its own: no record is split between two, and no older file is continued.
class TlogFiles {
 public:
  struct Options {
    std::filesystem::path folder;
    std::string name;  ///< without its extension; valid by tlog_name_fault()
    TlogRotation rotation;
    int max_files = 0;       ///< of all recordings with a date; 0: any number
    bool overwrite = false;  ///< replaces an old NAME.tlog; else it takes the next free number
  };

  /// Begins another recording and makes its first file. @return false with errno set
  bool begin(Options options, base::RunTime now);
  /// Writes whole records: one that the disk takes in part only is removed again. A file that has
  /// reached the largest size of the file system, or was closed after an error, is followed by the
  /// next one.
  /// @return how many of the bytes are in the files; fewer than all with errno set
  std::size_t write(std::span<const std::uint8_t> records, base::RunTime now);
  /// Closes the file. Logs an error if the disk reports lost packets at the close.
  void close();

  struct Content {
    std::uint64_t packets = 0;
    std::uint64_t bytes = 0;
  };
  /// Leaves a file that somebody has deleted; write() begins the next one.
  /// @return the content of the deleted file; nullopt if none is open or it still exists
  std::optional<Content> leave_deleted();

  const LogFolder& folder() const { return folder_; }
  /// The file that is written, or the last one; empty: none could be made.
  std::filesystem::path current() const;

 private:
  bool make_next(base::RunTime now);
  std::size_t append(std::span<const std::uint8_t> records);
  void give_up_file();
  bool is_full(std::size_t next_bytes, base::RunTime now) const;

  LogFolder folder_;
  Options options_;
  int number_ = 0;  ///< of the next file
  base::Descriptor fd_;
  std::uint64_t size_ = 0;
  std::uint64_t packets_ = 0;
  base::RunTime opened_{};
  std::deque<std::string> made_;  ///< the files that are kept, oldest first
  bool is_deleted_ = false;       ///< the last of them, by somebody
};

/// The time of its records, whatever the recorder's clock did.
using TlogClock = mav::services::TlogClock;

/// Reads a telemetry log file record by record, however long it is. Bytes that are no record are
/// skipped and counted.
class TlogReader {
 public:
  using Record = mav::services::TlogRecord;  ///< its packet is valid until the next call

  /// @return false when it cannot be read
  bool open(const std::filesystem::path& file);
  /// Nothing at the end. Reads on as long as it takes.
  std::optional<Record> next();
  /// The next record in what has been read; nothing: read_more() has the rest, if there is one.
  std::optional<Record> next_read() { return records_.next(ended_); }
  /// Reads one piece of the file. @return false at its end
  bool read_more();
  /// Whether reading failed before the end of the file.
  bool failed() const { return failed_; }
  std::uint64_t skipped_bytes() const { return records_.skipped_bytes(); }

 private:
  base::OpenFile file_;
  mav::services::TlogSplitter records_;
  bool ended_ = false;  ///< all of the file is fed
  bool failed_ = false;
};

}  // namespace cas::casd
