// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/write_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kNewFile = 0666;  // masked by the process's umask

/// @return errno, 0 when all is written
int write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(fd, text.data(), text.size());
    if (written < 0 && errno != EINTR) return errno;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

constexpr int kMostNames = 16;  // of files beside the one that is written

/// A new file "FILE.PID.new" beside another one, or "FILE.PID.N.new" if that name is taken: an
/// existing entry, above all a symlink, is not ours. @param beside  its name
/// @return empty, with errno set
Descriptor make_beside(const fs::path& file, fs::path& beside) {
  const std::string stem = file.string() + "." + std::to_string(::getpid());
  Descriptor out;
  for (int number = 0; !out && number < kMostNames; ++number) {
    beside = stem + (number > 0 ? "." + std::to_string(number) : "") + ".new";
    out = Descriptor(
        ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kNewFile));
    if (!out && errno != EEXIST) break;
  }
  return out;
}

/// @return errno, 0 when `out` holds the text and is closed
int fill(Descriptor out, const struct stat* old, std::string_view text, Durability durability) {
  if (old != nullptr && ::fchmod(out.get(), old->st_mode & 07777U) != 0) return errno;
  if (const int error = write_all(out.get(), text); error != 0) return error;
  if (durability == Durability::kDisk && ::fsync(out.get()) != 0) return errno;
  return ::close(out.release()) == 0 ? 0 : errno;
}

/// The rename is on the disk once the folder is. Some file systems cannot: then it comes later.
void sync_folder(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor) ::fsync(descriptor.get());
}

int write_in_place(const fs::path& file, std::string_view text) {
  const Descriptor out(::open(file.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC));
  struct stat now {};
  if (!out || ::fstat(out.get(), &now) != 0) return errno;
  if (S_ISREG(now.st_mode)) return EEXIST;  // another one took its place meanwhile
  return write_all(out.get(), text);
}

/// Whether a file may be written through this symlink: it leads to something, and the writing user
/// or root made it. In a shared folder any user may make one.
bool is_own_symlink(const struct stat& link, bool leads_somewhere) {
  return leads_somewhere && (link.st_uid == ::geteuid() || link.st_uid == 0);
}

int replace(const fs::path& file, const struct stat* old, std::string_view text,
            Durability durability) {
  fs::path beside;
  Descriptor out = make_beside(file, beside);
  if (!out) return errno;
  int error = fill(std::move(out), old, text, durability);
  if (error == 0 && ::rename(beside.c_str(), file.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(beside.c_str());
  } else if (durability == Durability::kDisk) {
    sync_folder(file);
  }
  return error;
}

}  // namespace

void write_file(const fs::path& file, std::string_view text, Durability durability) {
  struct stat link {};
  struct stat old {};
  const bool is_link = ::lstat(file.c_str(), &link) == 0 && S_ISLNK(link.st_mode);
  const bool exists = ::stat(file.c_str(), &old) == 0;
  int error = 0;
  if (is_link && !is_own_symlink(link, exists)) {
    throw ConfigError(file.string() + ": cannot be written: it is a symlink " +
                      (exists ? "that another user laid" : "to nothing"));
  }
  if (!exists) {
    error = replace(file, nullptr, text, durability);
  } else if (!S_ISREG(old.st_mode)) {
    error = write_in_place(file, text);
  } else {
    // A symlink stays one. A file that was no symlink is not checked again: it may have become one.
    std::error_code unresolved;
    const fs::path behind = is_link ? fs::canonical(file, unresolved) : file;
    error = replace(unresolved ? file : behind, &old, text, durability);
  }
  if (error == 0) return;
  throw ConfigError(file.string() +
                    ": cannot be written: " + std::generic_category().message(error));
}

}  // namespace cas::base
