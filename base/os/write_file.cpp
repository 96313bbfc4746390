// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/write_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kNewFile = 0666;  // less what the process's umask takes away

/// @return errno, 0 when all is written
int write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(fd, text.data(), text.size());
    if (written < 0 && errno != EINTR) return errno;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

/// @return errno, 0 when `beside` holds the text
int write_beside(const fs::path& beside, const struct stat* old, std::string_view text,
                 Durability durability) {
  Descriptor out(::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kNewFile));
  if (!out) return errno;
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
  const Descriptor out(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  return out ? write_all(out.get(), text) : errno;
}

int replace(const fs::path& file, const struct stat* old, std::string_view text,
            Durability durability) {
  fs::path beside = file;
  beside += "." + std::to_string(::getpid()) + ".new";
  int error = write_beside(beside, old, text, durability);
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
  struct stat old {};
  const bool exists = ::stat(file.c_str(), &old) == 0;
  int error = 0;
  if (!exists) {
    error = replace(file, nullptr, text, durability);
  } else if (!S_ISREG(old.st_mode)) {
    error = write_in_place(file, text);
  } else {
    std::error_code unresolved;
    const fs::path behind = fs::canonical(file, unresolved);  // a symlink stays one
    error = replace(unresolved ? file : behind, &old, text, durability);
  }
  if (error == 0) return;
  throw ConfigError(file.string() +
                    ": cannot be written: " + std::generic_category().message(error));
}

}  // namespace cas::base
