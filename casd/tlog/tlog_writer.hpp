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
#include <thread>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/tlog/tlog_files.hpp"

namespace cas::casd {

/// Writes packets into a telemetry log as ground stations read it: for each packet the time as an
/// 8-byte big-endian number of microseconds since 1970, then the packet as it came.
///
/// `record` only copies into memory; a thread of its own writes. When the disk does not keep up,
/// packets are left out of the log and counted.
class TlogWriter {
 public:
  /// Stamp of stream time zero in a log made in lockstep: 2026-01-01T00:00:00Z.
  static constexpr std::chrono::seconds kStreamEpoch{1'767'225'600};

  TlogWriter() = default;
  ~TlogWriter();
  TlogWriter(const TlogWriter&) = delete;
  TlogWriter& operator=(const TlogWriter&) = delete;

  /// Starts a new file. @throws base::ConfigError when it cannot be created
  void start(const std::filesystem::path& file, const TlogRotation& rotation = {});
  /// The time of day at run time zero of the logs to come, where run time is no clock of this
  /// machine (lockstep); else the logs have the time of day as it is.
  void set_epoch(std::chrono::nanoseconds since_1970) { epoch_ = since_1970; }
  /// Writes what is left and closes.
  void stop();
  bool active() const { return active_.load(std::memory_order_relaxed); }
  /// The file that is being written, or the last one.
  std::filesystem::path file() const;

  /// From any thread; does nothing while no log is open.
  void record(std::span<const std::uint8_t> packet, base::RunTime now);

  std::uint64_t recorded() const { return recorded_.load(std::memory_order_relaxed); }
  std::uint64_t left_out() const { return left_out_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kMaxWaitingBytes = 8 * 1024 * 1024;

  void run();
  bool write(std::span<const std::uint8_t> records);

  std::atomic<bool> active_{false};
  std::atomic<std::uint64_t> recorded_{0};
  std::atomic<std::uint64_t> left_out_{0};

  mutable std::mutex mutex_;
  std::condition_variable more_;
  std::vector<std::uint8_t> waiting_;
  bool stopping_ = false;
  std::optional<std::chrono::nanoseconds> epoch_;
  std::int64_t unix_minus_run_ns_ = 0;  ///< wall clock at run time zero
  std::filesystem::path path_;
  TlogFiles files_;  ///< of the thread, once it runs
  std::thread thread_;
};

}  // namespace cas::casd
