// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "mavlink_gen/services/tlog.hpp"

namespace cas::casd {

/// Reads a telemetry log on a thread of its own, ahead of its player: neither a slow disk nor a
/// long stretch without a packet holds up the player's thread. At most two pieces of the file are
/// in memory.
///
///   file --> thread: read, find records --> Shared::records --> next()
///                 ^---- waits until they are taken ----+
class TlogReadAhead {
 public:
  using Record = mav::services::TlogRecord;  ///< its packet is valid until the next call

  /// @throws std::system_error when there is no thread to be had
  explicit TlogReadAhead(const std::filesystem::path& file);
  /// Does not wait: a thread that hangs in a read ends by itself.
  ~TlogReadAhead();
  TlogReadAhead(const TlogReadAhead&) = delete;
  TlogReadAhead& operator=(const TlogReadAhead&) = delete;

  /// The next record; nothing while none is read, and at the end. Never waits.
  std::optional<Record> next();
  /// No record follows.
  bool ended() const { return last_ && at_ == records_.size(); }
  /// The file could not be opened, or not read to its end; known once ended() is true.
  bool unreadable() const { return unreadable_; }
  /// Bytes that are no record, up to the last piece that was taken.
  std::uint64_t skipped_bytes() const { return skipped_bytes_; }

 private:
  /// One piece of the log. The thread owns it while `full` is false, the player while it is true.
  struct Shared {
    std::atomic<bool> full{false};
    std::atomic<bool> abandoned{false};
    std::vector<std::uint8_t> records;  ///< whole ones
    bool last = false;
    bool unreadable = false;
    std::uint64_t skipped_bytes = 0;
  };

  static void read(const std::filesystem::path& file, Shared& shared);
  static bool hand_over(Shared& shared);
  bool take_piece();

  std::shared_ptr<Shared> shared_;
  std::vector<std::uint8_t> records_;
  std::size_t at_ = 0;
  bool last_ = false;
  bool unreadable_ = false;
  std::uint64_t skipped_bytes_ = 0;
};

}  // namespace cas::casd
