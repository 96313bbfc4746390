// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/file_at.hpp"

#include <fcntl.h>
#include <limits.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <deque>
#include <utility>

#include "base/error.hpp"
#include "base/os/disk_error.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

// Modes of new files and folders, before the process's umask.
constexpr mode_t kNewFileMode = 0666;
constexpr mode_t kNewFolder = 0777;
constexpr int kMostNames = 16;  // tried for the file beside the one that is written
constexpr int kMostLinks = 40;  // symlinks on one path: the kernel's own bound

[[noreturn]] void fail(const fs::path& file, const std::string& why) {
  throw ConfigError(file.string() + ": cannot be written: " + why);
}

[[noreturn]] void fail(const fs::path& file, int error) { fail(file, error_text(error)); }

/// Inserts the components of a path before those that are still to be opened.
void put_in_front(const fs::path& path, std::deque<std::string>& left) {
  const fs::path relative = path.relative_path();
  left.insert(left.begin(), relative.begin(), relative.end());
}

/// @param link  open with O_PATH
std::string target_of(int link, const fs::path& file) {
  std::array<char, PATH_MAX> text{};
  const ssize_t size = ::readlinkat(link, "", text.data(), text.size());
  if (size <= 0) fail(file, size == 0 ? ENOENT : errno);
  return {text.data(), static_cast<std::size_t>(size)};
}

Descriptor open_root() { return Descriptor(::open("/", O_PATH | O_DIRECTORY | O_CLOEXEC)); }

/// A new file "NAME.PID.new" in the folder, or "NAME.PID.N.new" if that name is taken: an existing
/// entry, above all a symlink, is not ours. @param beside  its name
/// @return empty, with errno set
Descriptor make_beside(int folder, const std::string& name, std::string& beside) {
  const std::string stem = name + "." + std::to_string(::getpid());
  Descriptor out;
  for (int number = 0; !out && number < kMostNames; ++number) {
    beside = stem + (number > 0 ? "." + std::to_string(number) : "") + ".new";
    out = Descriptor(::openat(folder, beside.c_str(),
                              O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kNewFileMode));
    if (!out && errno != EEXIST) break;
  }
  return out;
}

/// @return errno, 0 when `out` holds the text and is closed
int fill(Descriptor out, const struct stat* old, std::string_view text, Durability durability) {
  if (old != nullptr && ::fchmod(out.get(), old->st_mode & 07777U) != 0) return errno;
  if (const int error = write_all(out.get(), text); error != 0) return error;
  if (durability == Durability::kDisk && ::fsync(out.get()) != 0) return errno;
  return close_written(out);
}

/// Writes the rename to the disk. On file systems that cannot sync a folder it gets there later.
void sync_folder(int folder) {
  const Descriptor descriptor(::openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor) ::fsync(descriptor.get());
}

}  // namespace

bool is_trusted_owner(const struct stat& of) { return of.st_uid == ::geteuid() || of.st_uid == 0; }

Descriptor open_folder(int start, const fs::path& folder, Symlinks symlinks, Absent absent,
                       const fs::path& file) {
  std::deque<std::string> left;
  put_in_front(folder, left);
  Descriptor at = folder.is_absolute()
                      ? open_root()
                      : Descriptor(::openat(start, ".", O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (!at) fail(file, errno);
  for (int followed = 0; !left.empty();) {
    const std::string name = std::exchange(left.front(), {});
    left.pop_front();
    if (name.empty() || name == ".") continue;
    const bool unmade =
        absent == Absent::kMade && ::mkdirat(at.get(), name.c_str(), kNewFolder) != 0;
    const int why_unmade = errno;
    Descriptor next(::openat(at.get(), name.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC));
    struct stat status {};
    if (!next) fail(file, unmade && errno == ENOENT ? why_unmade : errno);
    if (::fstat(next.get(), &status) != 0) fail(file, errno);
    if (S_ISLNK(status.st_mode)) {
      if (symlinks == Symlinks::kNone) fail(file, "'" + name + "' is a symlink");
      if (!is_trusted_owner(status)) {
        fail(file, "'" + name + "' is a symlink that another user laid");
      }
      if (++followed > kMostLinks) fail(file, ELOOP);
      const fs::path target = target_of(next.get(), file);
      put_in_front(target, left);
      if (target.is_absolute()) at = open_root();
      continue;
    }
    if (!S_ISDIR(status.st_mode)) fail(file, ENOTDIR);
    if (symlinks == Symlinks::kNone && !is_trusted_owner(status)) {
      fail(file, "'" + name + "' is a folder of another user, who may lay symlinks there");
    }
    at = std::move(next);
  }
  return at;
}

int write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(fd, text.data(), text.size());
    if (written < 0 && errno != EINTR) return errno;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

int replace_at(int folder, const std::string& name, const struct stat* old, std::string_view text,
               Durability durability) {
  std::string beside;
  Descriptor out = make_beside(folder, name, beside);
  if (!out) return errno;
  int error = fill(std::move(out), old, text, durability);
  if (error == 0 && ::renameat(folder, beside.c_str(), folder, name.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlinkat(folder, beside.c_str(), 0);
  } else if (durability == Durability::kDisk) {
    sync_folder(folder);
  }
  return error;
}

}  // namespace cas::base
