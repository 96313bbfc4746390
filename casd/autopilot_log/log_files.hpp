// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "base/os/descriptor.hpp"
#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "casd/autopilot_log/log_pull.hpp"
#include "casd/tlog/autopilot_log_config.hpp"
#include "casd/tlog/tlog_folder.hpp"

namespace cas::casd {

/// Writes the logs of autopilots. All calls only copy into memory; a thread of its own works on the
/// files, so that a disk that hangs keeps nobody else waiting.
///
/// Files are new ones, DATE-NAME.ulg and .bin (DATE-NAME.1.ulg where that is taken), never over
/// another file and never through a symlink. Where the disk does not take them, or a limit is
/// reached, takes() is false until there is room again; the log says so once.
class LogFiles {
 public:
  using File = std::uint32_t;
  /// How often is looked whether there is room again.
  static constexpr base::Duration kRetryPeriod = std::chrono::seconds(5);

  /// @throws base::ConfigError when the machine has no thread for it
  explicit LogFiles(AutopilotLogConfig config);
  /// Writes what waits.
  ~LogFiles();
  LogFiles(const LogFiles&) = delete;
  LogFiles& operator=(const LogFiles&) = delete;

  /// @param name  of its vehicle: "v1"
  File begin(const std::string& name, std::string_view extension);
  /// @return false when too much waits for the disk
  bool write(File file, LogPart part);
  void end(File file);
  bool takes() const { return takes_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kMaxWaitingBytes = 4 * 1024 * 1024;

  struct Job {
    enum class Kind : std::uint8_t { kBegin, kWrite, kEnd } kind{};
    File file = 0;
    std::string name{};  ///< without number: "DATE-v1"
    std::string extension{};
    LogPart part{};
  };
  struct Open {
    base::Descriptor fd;
    std::string name;  ///< in the folder
    std::uint64_t size = 0;
  };

  void order(Job job);
  void run(const std::stop_token& stop);
  void carry_out(Job job);
  void make(const Job& job);
  void append(File file, const LogPart& part);
  void close(File file);
  void fail(std::string why);
  void look_for_room();
  std::string lack(std::uint64_t more);

  AutopilotLogConfig config_;
  std::atomic<bool> takes_{true};

  base::Mutex mutex_;
  std::condition_variable_any more_;
  std::deque<Job> jobs_ CAS_GUARDED_BY(mutex_);
  std::size_t waiting_bytes_ CAS_GUARDED_BY(mutex_) = 0;
  File next_ CAS_GUARDED_BY(mutex_) = 1;

  // Of the thread that writes.
  TlogFolder folder_;
  std::map<File, Open> open_;
  TlogSpace space_;
  std::optional<base::RunTime> looked_;   ///< at what is free
  std::optional<base::RunTime> scanned_;  ///< what the logs take
  std::optional<base::RunTime> retry_at_;
  std::string why_;  ///< nothing is taken; empty: it is, and was

  std::jthread thread_;  ///< the last one: it ends before what it works on
};

}  // namespace cas::casd
