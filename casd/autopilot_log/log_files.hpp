// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "base/os/descriptor.hpp"
#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "casd/autopilot_log/log_pull.hpp"
#include "casd/tlog/log_folder.hpp"
#include "casd/tlog/log_room.hpp"

namespace cas::casd {

/// Whether casd has given a file its name: "2026-11-22T18-05-00Z-v1.ulg".
bool is_autopilot_log(std::string_view file);

/// The files of autopilots' logs as they are on the disk.
struct LogFilesStatus {
  struct Entry {
    std::filesystem::path path;
    std::uint64_t bytes = 0;
  };
  std::filesystem::path folder;
  std::optional<std::string> paused;  ///< reason of the pause, a clause; nullopt: not paused
  base::Duration paused_for{};
  std::map<std::uint32_t, Entry> open;  ///< files under way, by LogFiles::File
};

/// Writes the logs of autopilots. Calls only copy into memory; a thread of its own writes the
/// files, so a disk that hangs delays no other thread.
///
/// Each file is a new one, DATE-NAME.ulg or .bin (DATE-NAME.1.ulg if that exists): no file is
/// replaced, no symlink followed. When the disk fails or a limit is reached, takes() is false until
/// there is room again; casd's log says so once.
class LogFiles {
 public:
  using File = std::uint32_t;
  /// Time between two tests whether there is room again.
  static constexpr base::Duration kRetryPeriod = std::chrono::seconds(5);

  /// @throws base::ConfigError when the machine has no thread for it
  LogFiles(std::filesystem::path folder, LogLimits limits);
  /// Writes the rest of the queue.
  ~LogFiles();
  LogFiles(const LogFiles&) = delete;
  LogFiles& operator=(const LogFiles&) = delete;

  /// @param name  of the vehicle in the file's name: "v1"
  File begin(const std::string& name, std::string_view extension);
  /// @return false when the queue to the disk is full
  bool write(File file, LogPart part);
  void end(File file);
  bool takes() const { return takes_.load(std::memory_order_relaxed); }
  LogFilesStatus status(base::RunTime now) const;

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

  void enqueue(Job job);
  /// Waits for work and does it. @return false at the end
  bool work(const std::stop_token& stop);
  void carry_out(const Job& job);
  void make(const Job& job);
  void append(File file, const LogPart& part);
  void close(File file);
  void fail(const std::string& why);
  void look_for_room();
  void publish();

  std::atomic<bool> takes_{true};

  base::Mutex mutex_;
  std::condition_variable_any more_;
  std::deque<Job> jobs_ CAS_GUARDED_BY(mutex_);
  std::size_t waiting_bytes_ CAS_GUARDED_BY(mutex_) = 0;
  File next_ CAS_GUARDED_BY(mutex_) = 1;

  // Only the writing thread uses these.
  LogFolder folder_;
  LogRoom room_;
  std::map<File, Open> open_;
  std::optional<base::RunTime> retry_at_;
  std::optional<std::string> paused_;  ///< why no file is written
  base::RunTime paused_since_{};

  mutable base::Mutex status_mutex_;  ///< guards a copy that can be read while the disk is slow
  LogFilesStatus status_ CAS_GUARDED_BY(status_mutex_);
  base::RunTime status_paused_since_ CAS_GUARDED_BY(status_mutex_);

  std::jthread thread_;  ///< the last member: it ends before those that it uses
};

}  // namespace cas::casd
