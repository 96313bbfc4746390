// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "casd/tlog/log_folder.hpp"
#include "casd/tlog/tlog_recording.hpp"

namespace cas::casd {

/// State of the recording that runs, or else of the last one.
struct TlogStatus {
  bool active = false;         ///< begun and not ended; a pause does not end it
  std::filesystem::path file;  ///< empty: none yet
  /// Why nothing is written, as a clause; nullopt: nothing is wrong. Between two recordings: why
  /// none could begin when casd last looked.
  std::optional<std::string> paused;
  base::Duration paused_for{};
  std::uint64_t recorded = 0;  ///< packets in its files
  std::uint64_t left_out = 0;  ///< packets that are missing in them
  std::uint64_t bytes = 0;     ///< in its files
};

/// Writes packets into a telemetry log as ground stations read it: for each packet the time as an
/// 8-byte big-endian number of microseconds since 1970, then the packet as it came.
///
/// `record` only copies into memory; a thread of its own makes, writes and closes the files, so a
/// disk that hangs delays no other thread. Packets that a full or slow disk does not take are left
/// out of the log and counted.
///
///   link threads --record()---> waiting_ --every 200 ms--+
///   main ---------begin, end--> orders_ -----at once-----+--> recording_ --> disk
///                   (mutex_)                                 (its thread)
class TlogWriter {
 public:
  /// Stamp of stream time zero in a log made in lockstep: 2026-01-01T00:00:00Z.
  static constexpr std::chrono::seconds kStreamEpoch{1'767'225'600};
  /// In standby it keeps the packets of at least this time in memory.
  static constexpr base::Duration kKeptBefore = std::chrono::seconds(1);

  TlogWriter() = default;
  ~TlogWriter();
  TlogWriter(const TlogWriter&) = delete;
  TlogWriter& operator=(const TlogWriter&) = delete;

  /// Called on the thread that writes, once the disk has answered; at once where there was nothing
  /// to do.
  /// @param fault   why the recording has not begun; nullopt: it has, or it has ended
  /// @param status  of the recording that began or ended
  using Done =
      std::function<void(const std::optional<std::string>& fault, const TlogStatus& status)>;

  /// Begins a recording and ends the one before, without waiting for the disk. It begins with the
  /// packets kept in standby. If its file cannot be made, only the previous recording has ended.
  /// @throws base::ConfigError when no thread to write it can be made
  void start(TlogRecording::Options options, Done done);
  /// The same, and waits for the disk. @throws base::ConfigError also when its file cannot be made
  void start(TlogRecording::Options options);
  /// From now on the newest packets are kept while nothing is recorded, for the next start(). If
  /// the folder could take no recording, the log says so soon, and status() until it could.
  /// @throws base::ConfigError when the machine has no thread for it
  void stand_by(LogFolder folder, LogLimits limits);
  /// In lockstep run time is not this machine's clock: sets the time of day at run time zero for
  /// the next logs. Without it logs have the time of day.
  void set_epoch(std::chrono::nanoseconds since_1970) { epoch_ = since_1970; }
  /// Ends the recording: orders the rest to be written, and does not wait.
  void stop(Done done);
  /// The same, and waits until the disk has it.
  void stop();
  bool active() const { return phase_.load(std::memory_order_relaxed) == Phase::kRecording; }
  /// Whether record() does anything; if not, it need not be called.
  bool listens() const { return phase_.load(std::memory_order_relaxed) != Phase::kOff; }
  TlogStatus status(base::RunTime now) const;

  /// From any thread; does nothing while nothing is recorded and it does not stand by.
  void record(std::span<const std::uint8_t> packet, base::RunTime now);

 private:
  enum class Phase : std::uint8_t { kOff, kStandby, kRecording };
  /// Bound of the waiting packets, of those kept while standing by, and half of the bound of those
  /// that ends of recordings wait with.
  static constexpr std::size_t kMaxWaitingBytes = 8 * 1024 * 1024;

  /// Packets on their way to the disk.
  struct Load {
    std::vector<std::uint8_t> before;
    std::vector<std::uint8_t> records;
    std::uint64_t overflowed = 0;  ///< packets that there was no room for
  };
  /// The beginning of a recording, or its end with the last of its packets.
  struct Order {
    std::optional<TlogRecording::Options> begin;
    Load rest;
    Done done;
  };

  void start_thread(std::function<void()> first = {});
  /// Waits for work and does it. @return false at the end
  bool work(const std::stop_token& stop);
  void look_at_folder(base::RunTime now);
  void carry_out(Order& order, bool newest, base::RunTime now);
  void begin_recording(Order& order, bool newest, base::RunTime now);
  void begin_failed();
  void order_end(Done done) CAS_REQUIRES(mutex_);
  void set_zero(base::RunTime now) CAS_REQUIRES(mutex_);
  std::uint64_t stamp_of(base::RunTime now) CAS_REQUIRES(mutex_);
  Load take_waiting() CAS_REQUIRES(mutex_);
  void write(const Load& load, base::RunTime now);
  TlogStatus publish();

  std::atomic<Phase> phase_{Phase::kOff};

  mutable base::Mutex mutex_;  ///< held for copies only: packets come through it
  std::deque<Order> orders_ CAS_GUARDED_BY(mutex_);
  std::size_t ordered_bytes_ CAS_GUARDED_BY(mutex_) = 0;  ///< of packets in orders_
  bool stands_by_ CAS_GUARDED_BY(mutex_) = false;
  std::condition_variable_any more_;
  std::vector<std::uint8_t> waiting_ CAS_GUARDED_BY(mutex_);
  /// In standby: the packets before those in `waiting_`.
  std::vector<std::uint8_t> before_ CAS_GUARDED_BY(mutex_);
  base::RunTime stretch_began_ CAS_GUARDED_BY(mutex_);
  std::uint64_t overflowed_ CAS_GUARDED_BY(mutex_) = 0;
  std::int64_t unix_minus_run_ns_ CAS_GUARDED_BY(mutex_) = 0;  ///< wall clock at run time zero
  std::uint64_t newest_us_ CAS_GUARDED_BY(mutex_) = 0;         ///< since 1970, of the newest record

  // Only the writing thread uses these.
  TlogRecording recording_;
  bool open_ = false;  ///< a recording has begun and not ended
  std::uint64_t recorded_ = 0;
  std::uint64_t left_out_ = 0;
  std::optional<LogFolder> folder_;  ///< of stand_by()
  LogLimits limits_;
  std::optional<std::string> fault_between_;  ///< TlogStatus::paused while nothing is recorded
  base::RunTime fault_since_{};

  mutable base::Mutex status_mutex_;  ///< guards a copy that can be read while the disk is slow
  TlogStatus status_ CAS_GUARDED_BY(status_mutex_);
  base::RunTime paused_since_ CAS_GUARDED_BY(status_mutex_);
  /// Recordings that were ordered and have not begun.
  int beginning_ CAS_GUARDED_BY(status_mutex_) = 0;
  /// Since when the disk has not answered.
  std::optional<base::RunTime> asked_disk_ CAS_GUARDED_BY(status_mutex_);

  std::optional<std::chrono::nanoseconds> epoch_;
  std::jthread thread_;  ///< the last member: it ends before those that it uses
};

}  // namespace cas::casd
