// SPDX-License-Identifier: BSD-3-Clause
#include "casd/autopilot_log/log_files.hpp"

#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <regex>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/os/disk_error.hpp"
#include "base/os/lack_of_memory.hpp"
#include "base/os/log.hpp"
#include "casd/tlog/tlog_name.hpp"

namespace cas::casd {
namespace {

constexpr auto kFlushPeriod = std::chrono::milliseconds(200);
/// Room that must be free before logs go on.
constexpr std::uint64_t kRoomToGoOn = 1024 * 1024;
constexpr int kMostFiles = 10'000;  // names that are tried

/// Any peer can send logs: their size is bounded unless the topology says otherwise.
LogLimits bounded(LogLimits limits) {
  constexpr std::uint64_t kMaxBytes = std::uint64_t{4} * 1024 * 1024 * 1024;
  if (!limits.max_bytes) limits.max_bytes = kMaxBytes;
  return limits;
}

constexpr const char* kWho = "logs of autopilots";

}  // namespace

bool is_autopilot_log(std::string_view file) {
  static const std::regex kRest(R"(-v\d{1,3}(\.\d+)?\.(ulg|bin))");
  if (!is_dated(file)) return false;
  const std::string_view rest = file.substr(std::min(file.find('Z') + 1, file.size()));
  return std::regex_match(rest.begin(), rest.end(), kRest);
}

LogFiles::LogFiles(std::filesystem::path folder, LogLimits limits)
    : folder_(std::move(folder), {".ulg", ".bin"}, is_autopilot_log), room_(bounded(limits)) {
  publish();
  try {
    thread_ = std::jthread([this](const std::stop_token& stop) {
      // A folder that takes no files says so now, not at the first flight.
      base::outlive_lack_of_memory(kWho, [this] {
        if (!folder_.takes_files()) fail(base::error_text(errno));
      });
      for (bool goes_on = true; goes_on;) {
        base::outlive_lack_of_memory(kWho, [&] { goes_on = work(stop); });
      }
    });
  } catch (const std::system_error& error) {
    throw base::ConfigError(std::string("cannot take logs of autopilots: no thread for it: ") +
                            error.what());
  }
}

LogFiles::~LogFiles() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

LogFiles::File LogFiles::begin(const std::string& name, std::string_view extension) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  Job job{.kind = Job::Kind::kBegin,
          .name = dated_tlog_name(std::chrono::duration_cast<std::chrono::seconds>(now), name),
          .extension = "." + std::string(extension)};
  {
    const base::MutexLock lock(mutex_);
    job.file = next_++;
  }
  const File file = job.file;
  enqueue(std::move(job));
  return file;
}

bool LogFiles::write(File file, LogPart part) {
  {
    const base::MutexLock lock(mutex_);
    if (waiting_bytes_ + part.bytes.size() > kMaxWaitingBytes) return false;
  }
  enqueue({.kind = Job::Kind::kWrite, .file = file, .part = std::move(part)});
  return true;
}

void LogFiles::end(File file) { enqueue({.kind = Job::Kind::kEnd, .file = file}); }

void LogFiles::enqueue(Job job) {
  const base::MutexLock lock(mutex_);
  waiting_bytes_ += job.part.bytes.size() + sizeof(Job);
  jobs_.push_back(std::move(job));
}

bool LogFiles::work(const std::stop_token& stop) {
  bool goes_on = true;
  std::deque<Job> jobs;
  {
    base::MutexLock lock(mutex_);
    more_.wait_for(lock, stop, kFlushPeriod, [] { return false; });
    goes_on = !stop.stop_requested();
    jobs.swap(jobs_);
    waiting_bytes_ = 0;
  }
  for (; !jobs.empty(); jobs.pop_front()) {
    const Job& job = jobs.front();
    if (base::outlive_lack_of_memory(kWho, [&] { carry_out(job); })) continue;
    open_.erase(job.file);  // what follows would have a gap before it
    fail("no memory");
  }
  look_for_room();
  publish();
  while (!goes_on && !open_.empty()) close(open_.begin()->first);
  return goes_on;
}

void LogFiles::carry_out(const Job& job) {
  switch (job.kind) {
    case Job::Kind::kBegin:
      return make(job);
    case Job::Kind::kWrite:
      return append(job.file, job.part);
    case Job::Kind::kEnd:
      return close(job.file);
  }
}

void LogFiles::make(const Job& job) {
  if (paused_) return;
  Open file;
  for (int number = 0; !file.fd; ++number) {
    file.name = job.name + (number > 0 ? fmt::format(".{}", number) : "") + job.extension;
    file.fd = folder_.make(file.name);
    if (!file.fd && (errno != EEXIST || number >= kMostFiles)) return fail(base::error_text(errno));
  }
  folder_.keep_newest(room_.limits().max_files, file.name);
  room_.look_again();
  open_.emplace(job.file, std::move(file));
}

/// Writes all of it. On failure the file gets its old length and is closed.
void LogFiles::append(File id, const LogPart& part) {
  const auto found = open_.find(id);
  if (found == open_.end()) return;
  Open& file = found->second;
  if (is_deleted(file.fd)) {
    const std::string name = file.name;
    open_.erase(found);
    return fail(name + " was deleted while it was written");
  }
  if (const auto why = room_.lack(folder_, part.bytes.size(), {}, base::steady_now())) {
    close(id);
    return fail(*why);
  }
  if (file.size == 0) {
    base::log::info("recording the autopilot's log in " + (folder_.path() / file.name).string());
  }
  const bool padded = !part.at || *part.at <= file.size ||
                      ::ftruncate(file.fd.get(), static_cast<off_t>(*part.at)) == 0;
  if (!padded || write_some(file.fd.get(), part.bytes) < part.bytes.size()) {
    const int error = errno;
    if (::ftruncate(file.fd.get(), static_cast<off_t>(file.size)) != 0) {
      base::log::warn((folder_.path() / file.name).string() + " ends in the middle of a message");
    }
    close(id);
    return fail(base::error_text(error));
  }
  const std::uint64_t before = file.size;
  file.size = std::max(file.size, part.at.value_or(0)) + part.bytes.size();
  room_.wrote(file.size - before);
}

void LogFiles::close(File id) {
  const auto found = open_.find(id);
  if (found == open_.end()) return;
  Open& file = found->second;
  const bool deleted = is_deleted(file.fd);
  const int error = base::close_written(file.fd);
  if (error != 0) {
    base::log::error("the autopilot's log " + (folder_.path() / file.name).string() +
                     " may lack its end: closing it failed: " + base::error_text(error));
  }
  if (deleted) {
    base::log::error(
        fmt::format("the autopilot's log {} was deleted while it was written, with {} bytes in it",
                    (folder_.path() / file.name).string(), file.size));
  } else if (file.size == 0) {
    folder_.remove(file.name);
  } else {
    base::log::info(fmt::format("the autopilot's log {} has {} bytes",
                                (folder_.path() / file.name).string(), file.size));
  }
  open_.erase(found);
}

void LogFiles::fail(const std::string& why) {
  retry_at_ = base::steady_now() + kRetryPeriod;
  takes_.store(false, std::memory_order_relaxed);
  if (!paused_) {
    base::log::error("logs of autopilots in " + folder_.path().string() + " pause: " + why +
                     "; they go on when they can");
    paused_since_ = base::steady_now();
  }
  paused_ = why;
}

/// Logs go on once a test file can be written; each then begins a new file.
void LogFiles::look_for_room() {
  if (!retry_at_ || base::steady_now() < *retry_at_) return;
  retry_at_ = base::steady_now() + kRetryPeriod;
  room_.look_again();
  if (folder_.hindrance(room_.limits(), kRoomToGoOn)) return;
  retry_at_.reset();
  paused_.reset();
  takes_.store(true, std::memory_order_relaxed);
  base::log::info("logs of autopilots go on in " + folder_.path().string());
}

LogFilesStatus LogFiles::status(base::RunTime now) const {
  const base::MutexLock lock(status_mutex_);
  LogFilesStatus status = status_;
  if (status.paused) status.paused_for = now - status_paused_since_;
  return status;
}

void LogFiles::publish() {
  LogFilesStatus status;
  status.folder = folder_.path();
  status.paused = paused_;
  for (const auto& [id, file] : open_) {
    if (file.size > 0) status.open[id] = {folder_.path() / file.name, file.size};
  }
  const base::MutexLock lock(status_mutex_);
  status_ = std::move(status);
  status_paused_since_ = paused_since_;
}

}  // namespace cas::casd
