// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/log_folder.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "base/os/file_lock.hpp"
#include "base/os/log.hpp"

namespace cas::casd {
namespace {

constexpr mode_t kNewFolder = 0777;  // masked by the process's umask
constexpr mode_t kNewFile = 0640;    // it shows where a vehicle was

/// A symlink in its place is followed when root or this user laid it. @return nothing with errno
/// set, ELOOP for another one
base::Descriptor open_folder(const std::filesystem::path& folder) {
  // With a slash at its end lstat(2) would look behind the symlink.
  const std::filesystem::path path = folder.has_filename() ? folder : folder.parent_path();
  int how = O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW;
  struct stat status {};
  if (::lstat(path.c_str(), &status) == 0 && S_ISLNK(status.st_mode)) {
    if (status.st_uid != 0 && status.st_uid != ::geteuid()) {
      errno = ELOOP;
      return {};
    }
    how &= ~O_NOFOLLOW;
  }
  return base::Descriptor(::open(path.c_str(), how));
}

std::string mib(std::uint64_t bytes) { return fmt::format("{} MiB", bytes / (1024 * 1024)); }

/// Calls visit(name, status) for each regular file of a folder with one of the extensions.
template <class Visit>
void for_each_recording(const std::filesystem::path& path, const LogFolder::Extensions& extensions,
                        Visit&& visit) {
  const std::unique_ptr<DIR, int (*)(DIR*)> folder(::opendir(path.c_str()), &::closedir);
  while (folder) {
    const dirent* entry = ::readdir(folder.get());
    if (entry == nullptr) break;
    struct stat status {};
    const std::string_view name(entry->d_name);
    const auto is_its = [name](std::string_view extension) { return name.ends_with(extension); };
    if (std::none_of(extensions.begin(), extensions.end(), is_its)) continue;
    if (::fstatat(::dirfd(folder.get()), entry->d_name, &status, AT_SYMLINK_NOFOLLOW) != 0)
      continue;
    if (S_ISREG(status.st_mode)) visit(name, status);
  }
}

/// Whether a program may have the file open to record into it. Only a lock for writing counts,
/// so that a reader cannot keep a recording from being deleted.
bool is_written(int folder, const std::string& name) {
  const base::Descriptor file(
      ::openat(folder, name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  return !file || base::is_file_locked(file.get());
}

}  // namespace

std::optional<std::string> lack_of_room(const LogLimits& limits, const LogSpace& space,
                                        std::uint64_t more) {
  if (limits.free_space_min_bytes > 0 && space.free_bytes < limits.free_space_min_bytes + more) {
    return "less than " + mib(limits.free_space_min_bytes) + " would stay free";
  }
  const std::uint64_t most = limits.max_bytes.value_or(0);
  if (most > 0 && space.used_bytes + more > most) {
    return "the recordings have the " + mib(most) + " that they may take";
  }
  return std::nullopt;
}

LogFolder::LogFolder(std::filesystem::path path, Extensions extensions, IsOwn is_own)
    : path_(path.empty() ? "." : std::move(path)),
      extensions_(std::move(extensions)),
      is_own_(is_own) {}

base::Descriptor LogFolder::make(const std::string& name) const {
  base::Descriptor folder = open_folder(path_);
  if (!folder && errno == ENOENT) {
    // EEXIST: another thread made it meanwhile, or it is a symlink that leads nowhere, ENOENT then.
    if (::mkdir(path_.c_str(), kNewFolder) == 0 || errno == EEXIST) folder = open_folder(path_);
  }
  if (!folder) return {};
  // O_APPEND: after a torn record is cut off, the next one begins in its place.
  constexpr int kHow = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_APPEND | O_CLOEXEC;
  base::Descriptor file(::openat(folder.get(), name.c_str(), kHow, kNewFile));
  if (file) base::take_file_lock(file.get());  // some file systems have no locks
  return file;
}

bool LogFolder::takes_files() const {
  static std::atomic<unsigned> calls{0};
  const std::string name = fmt::format(".casd-{}-{}", ::getpid(), calls.fetch_add(1));
  remove(name);  // of a casd that was killed
  const base::Descriptor file = make(name);
  if (!file) return false;
  const ssize_t written = ::write(file.get(), "?", 1);
  const int error = written == 0 ? ENOSPC : errno;
  remove(name);
  errno = error;
  return written == 1;
}

bool LogFolder::remove(const std::string& name) const {
  const base::Descriptor folder = open_folder(path_);
  return folder && ::unlinkat(folder.get(), name.c_str(), 0) == 0;
}

std::vector<LogFolder::File> LogFolder::removable(const std::string& current) const {
  constexpr std::size_t kMostFiles = 100'000;  // that are looked at
  std::vector<File> files;
  const base::Descriptor folder = open_folder(path_);
  if (!folder) return files;
  for_each_recording(path_, extensions_, [&](std::string_view name, const struct stat& status) {
    const bool own = status.st_uid == ::geteuid() && is_own_(name);
    if (!own || name == current || files.size() >= kMostFiles) return;
    files.push_back(
        {std::string(name), static_cast<std::uint64_t>(status.st_size), status.st_mtim.tv_sec});
  });
  std::erase_if(files, [&](const File& file) { return is_written(folder.get(), file.name); });
  // By the last write: a recording that began before a clock without battery was set has an old
  // date in its name.
  std::ranges::sort(files, [](const File& file, const File& other) {
    if (file.written_s != other.written_s) return file.written_s < other.written_s;
    return older_tlog(file.name, other.name);
  });
  return files;
}

std::optional<std::string> LogFolder::hindrance(const LogLimits& limits, std::uint64_t room) const {
  if (auto why = lack(limits, room, {})) return why;
  // Old logs make room when there is a new one, not before.
  const bool makes_room = limits.delete_oldest && limits.free_space_min_bytes > 0;
  if (!makes_room && look(false).free_bytes < room) return base::error_text(ENOSPC);
  if (takes_files() || (makes_room && errno == ENOSPC)) return std::nullopt;
  return base::error_text(errno);
}

void LogFolder::keep_newest(int max_files, const std::string& current) const {
  if (max_files <= 0) return;
  for (const std::string& name : remove_oldest(static_cast<std::size_t>(max_files), current)) {
    base::log::info(
        fmt::format("logs: deleted {}, {} files may stay", (path_ / name).string(), max_files));
  }
}

std::vector<std::string> LogFolder::remove_oldest(std::size_t keep,
                                                  const std::string& current) const {
  std::size_t all = 0;
  for_each_recording(path_, extensions_, [&](std::string_view name, const struct stat& status) {
    all += status.st_uid == ::geteuid() && is_own_(name) ? 1U : 0U;
  });
  std::vector<std::string> gone;
  if (all <= keep) return gone;
  for (File& file : removable(current)) {
    if (gone.size() >= all - keep) break;
    if (remove(file.name)) gone.push_back(std::move(file.name));
  }
  return gone;
}

std::optional<std::string> LogFolder::lack(const LogLimits& limits, std::uint64_t more,
                                           const std::string& current) const {
  LogSpace space = look(limits.max_bytes > 0U);
  const auto now = lack_of_room(limits, space, more);
  if (!now || !limits.delete_oldest) return now;
  for (const File& file : removable(current)) {
    space.free_bytes += file.bytes;
    space.used_bytes -= std::min(file.bytes, space.used_bytes);
  }
  auto why = lack_of_room(limits, space, more);
  if (why) *why += ", and no old files would make enough room";
  return why;
}

std::vector<std::string> LogFolder::make_room(const LogLimits& limits, std::uint64_t more,
                                              const std::string& current) const {
  std::vector<std::string> gone;
  if (lack(limits, more, current)) return gone;
  // By their sizes: a file system may take a while to give the space back.
  LogSpace space = look(limits.max_bytes > 0U);
  for (File& file : removable(current)) {
    if (!lack_of_room(limits, space, more)) break;
    if (!remove(file.name)) continue;
    space.free_bytes += file.bytes;
    space.used_bytes -= std::min(file.bytes, space.used_bytes);
    base::log::info("logs: deleted " + (path_ / file.name).string() + " to make room");
    gone.push_back(std::move(file.name));
  }
  return gone;
}

LogSpace LogFolder::look(bool scan) const {
  LogSpace space;
  struct statvfs disk {};
  const bool known = ::statvfs(path_.c_str(), &disk) == 0;
  space.free_bytes = known ? std::uint64_t{disk.f_bavail} * disk.f_frsize
                           : std::numeric_limits<std::uint64_t>::max();
  if (!scan) return space;
  for_each_recording(path_, extensions_, [&](std::string_view, const struct stat& status) {
    space.used_bytes += static_cast<std::uint64_t>(status.st_size);
  });
  return space;
}

std::size_t write_some(int fd, std::span<const std::uint8_t> bytes) {
  std::size_t gone = 0;
  while (gone < bytes.size()) {
    const ssize_t written = ::write(fd, bytes.data() + gone, bytes.size() - gone);
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = ENOSPC;
    if (written <= 0) break;
    gone += static_cast<std::size_t>(written);
  }
  return gone;
}

bool is_deleted(const base::Descriptor& file) {
  struct stat status {};
  return file && ::fstat(file.get(), &status) == 0 && status.st_nlink == 0;
}

std::filesystem::path default_log_folder() {
  const char* given = std::getenv("LOGS_DIRECTORY");  // systemd, from LogsDirectory=
  if (given == nullptr || *given == '\0') return ".";
  const std::string_view folders = given;
  return folders.substr(0, folders.find(':'));
}

}  // namespace cas::casd
