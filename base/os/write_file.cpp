// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/write_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"
#include "base/os/disk_error.hpp"
#include "base/os/file_at.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

int write_in_place(int folder, const std::string& name, std::string_view text) {
  const Descriptor out(::openat(folder, name.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC));
  struct stat now {};
  if (!out || ::fstat(out.get(), &now) != 0) return errno;
  if (S_ISREG(now.st_mode)) return EEXIST;  // another one took its place meanwhile
  return write_all(out.get(), text);
}

Descriptor folder_of(const fs::path& place, const fs::path& file) {
  return open_folder(AT_FDCWD, place.parent_path(), Symlinks::kTrusted, Absent::kRefused, file);
}

/// Replaces the file that a symlink leads to: the symlink stays one.
int replace_behind(const fs::path& file, const struct stat& old, std::string_view text,
                   Durability durability) {
  std::error_code unresolved;
  const fs::path behind = fs::canonical(file, unresolved);
  if (unresolved) return unresolved.value();
  return replace_at(folder_of(behind, file).get(), behind.filename(), &old, text, durability);
}

}  // namespace

void write_file(const fs::path& file, std::string_view text, Durability durability) {
  const Descriptor folder = folder_of(file, file);
  const std::string name = file.filename();
  struct stat link {};
  struct stat old {};
  const bool is_link = ::fstatat(folder.get(), name.c_str(), &link, AT_SYMLINK_NOFOLLOW) == 0 &&
                       S_ISLNK(link.st_mode);
  const bool exists = ::fstatat(folder.get(), name.c_str(), &old, 0) == 0;
  int error = 0;
  if (is_link && !(exists && is_trusted_owner(link))) {
    throw ConfigError(file.string() + ": cannot be written: it is a symlink " +
                      (exists ? "that another user laid" : "to nothing"));
  }
  if (!exists) {
    error = replace_at(folder.get(), name, nullptr, text, durability);
  } else if (!S_ISREG(old.st_mode)) {
    error = write_in_place(folder.get(), name, text);
  } else if (is_link) {
    error = replace_behind(file, old, text, durability);
  } else {
    error = replace_at(folder.get(), name, &old, text, durability);
  }
  if (error == 0) return;
  throw_unwritten(file.string() + ": cannot be written: " + error_text(error), error);
}

}  // namespace cas::base
