// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/tlog/tlog_recording.hpp"

namespace cas::casd {

/// What is said about a recording: of the one under way, or else of the last one.
struct TlogStatus {
  bool active = false;         ///< begun and not ended; a pause does not end it
  std::filesystem::path file;  ///< empty: none yet
  std::string paused;          ///< why nothing is written, as a clause; empty: it is
  base::Duration paused_for{};
  std::uint64_t recorded = 0;  ///< packets in its files
  std::uint64_t left_out = 0;  ///< packets that are in none of them
  std::uint64_t bytes = 0;     ///< in its files
};

/// Writes packets into a telemetry log as ground stations read it: for each packet the time as an
/// 8-byte big-endian number of microseconds since 1970, then the packet as it came.
///
/// `record` only copies into memory; a thread of its own writes. What the disk does not take (it is
/// full or too slow) is left out of the log and counted.
///
///   link threads --record()--> waiting_ --every 200 ms--> recording_ --> disk
///                    (mutex_)                      (files_mutex_)
///
/// Whoever holds files_mutex_ may wait for the disk; it is never taken with mutex_ held.
class TlogWriter {
 public:
  /// Stamp of stream time zero in a log made in lockstep: 2026-01-01T00:00:00Z.
  static constexpr std::chrono::seconds kStreamEpoch{1'767'225'600};
  /// While it stands by, the packets of at least this long are kept in memory.
  static constexpr base::Duration kKeptBefore = std::chrono::seconds(1);

  TlogWriter() = default;
  ~TlogWriter();
  TlogWriter(const TlogWriter&) = delete;
  TlogWriter& operator=(const TlogWriter&) = delete;

  /// Begins a recording and ends the one before. It begins with what was kept while it stood by.
  /// @throws base::ConfigError when its file, or a thread to write it, cannot be made; then nothing
  /// has changed but that the recording before has ended
  void start(TlogRecording::Options options);
  /// From now on the newest packets are kept while nothing is recorded, for the next start().
  /// @throws base::ConfigError when the machine has no thread for it
  void stand_by();
  /// The time of day at run time zero of the logs to come, where run time is no clock of this
  /// machine (lockstep); else the logs have the time of day as it is.
  void set_epoch(std::chrono::nanoseconds since_1970) { epoch_ = since_1970; }
  /// Writes what is left and closes.
  void stop();
  bool active() const { return phase_.load(std::memory_order_relaxed) == Phase::kRecording; }
  /// Whether record() does anything; what it does not want need not be brought to it.
  bool listens() const { return phase_.load(std::memory_order_relaxed) != Phase::kOff; }
  TlogStatus status(base::RunTime now) const;

  /// From any thread; does nothing while nothing is recorded and it does not stand by.
  void record(std::span<const std::uint8_t> packet, base::RunTime now);

 private:
  enum class Phase : std::uint8_t { kOff, kStandby, kRecording };
  /// Both what waits and what was kept before stay below this.
  static constexpr std::size_t kMaxWaitingBytes = 8 * 1024 * 1024;

  void start_thread();
  void run();
  void flush(base::RunTime now);
  void set_zero(base::RunTime now);
  std::uint64_t stamp_of(base::RunTime now);
  void take_waiting();
  void write_taken(base::RunTime now);
  void publish();

  std::atomic<Phase> phase_{Phase::kOff};

  std::mutex mutex_;  ///< held for copies only: packets come through it
  bool stands_by_ = false;
  std::condition_variable more_;
  std::vector<std::uint8_t> waiting_;
  std::vector<std::uint8_t> before_;  ///< the stretch before `waiting_`, while it stands by
  base::RunTime stretch_began_{};
  std::uint64_t overflowed_ = 0;
  std::int64_t unix_minus_run_ns_ = 0;  ///< wall clock at run time zero
  std::uint64_t newest_us_ = 0;         ///< since 1970, of the newest record
  bool ending_ = false;

  std::mutex files_mutex_;
  TlogRecording recording_;
  std::vector<std::uint8_t> taken_before_;
  std::vector<std::uint8_t> taken_;
  std::uint64_t recorded_ = 0;
  std::uint64_t left_out_ = 0;

  mutable std::mutex status_mutex_;  ///< of a copy that can be read while the disk is slow
  TlogStatus status_;
  base::RunTime paused_since_{};

  std::optional<std::chrono::nanoseconds> epoch_;
  std::thread thread_;
};

}  // namespace cas::casd
