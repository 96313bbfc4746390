// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/result_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>

#include "base/error.hpp"
#include "base/os/disk_error.hpp"
#include "base/os/file_at.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kNewFile = 0666;  // masked by the process's umask

[[noreturn]] void fail(const ResultPlace& place, const std::string& why) {
  throw ConfigError(place.path().string() + ": cannot be written: " + why);
}

[[noreturn]] void fail(const ResultPlace& place, int error) {
  throw_unwritten(place.path().string() + ": cannot be written: " + error_text(error), error);
}

/// The file's path below `out`; empty: the file does not begin with `out`.
fs::path behind_out(const ResultPlace& place) {
  fs::path relative = place.file.lexically_relative(place.out);
  if (!relative.empty() && *relative.begin() == "..") relative.clear();
  return relative;
}

/// The place's path from `out` on. @throws ConfigError when it is not below it
fs::path below_out(const ResultPlace& place) {
  const fs::path behind = behind_out(place);
  const fs::path& below = behind.empty() ? place.file : behind;
  if (!fault_of_result_path(below).empty()) {
    fail(place, "it is not below " + place.out.string());
  }
  return below;
}

/// The folder that the results are below, and one below it; the first must exist.
Descriptor open_below(const ResultPlace& place, const fs::path& folder, Absent absent) {
  const Descriptor top =
      open_folder(AT_FDCWD, place.out, Symlinks::kTrusted, Absent::kRefused, place.path());
  return open_folder(top.get(), folder, Symlinks::kNone, absent, place.path());
}

}  // namespace

fs::path ResultPlace::path() const { return behind_out(*this).empty() ? out / file : file; }

std::string_view fault_of_result_path(const fs::path& path) {
  if (path.empty()) return "is empty; it names a file in the folder of results";
  if (path.is_absolute()) return "is absolute; files are written below the folder of results alone";
  if (std::ranges::find(path, fs::path("..")) != path.end()) {
    return "has '..'; files are written below the folder of results alone";
  }
  return "";
}

void make_out_folder(const fs::path& out) {
  open_folder(AT_FDCWD, out, Symlinks::kTrusted, Absent::kMade, out);
}

void write_result(const ResultPlace& place, std::string_view text, Durability durability) {
  const fs::path below = below_out(place);
  const Descriptor folder = open_below(place, below.parent_path(), Absent::kMade);
  const int error = replace_at(folder.get(), below.filename(), nullptr, text, durability);
  if (error != 0) fail(place, error);
}

Descriptor make_result(const ResultPlace& place) {
  const fs::path below = below_out(place);
  const Descriptor folder = open_below(place, below.parent_path(), Absent::kMade);
  const std::string name = below.filename();
  // A new file, so that a link of any kind in its place leads nowhere.
  if (::unlinkat(folder.get(), name.c_str(), 0) != 0 && errno != ENOENT) fail(place, errno);
  Descriptor made(::openat(folder.get(), name.c_str(),
                           O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kNewFile));
  if (!made) fail(place, errno);
  return made;
}

Descriptor append_result(const ResultPlace& place) {
  const fs::path below = below_out(place);
  const Descriptor folder = open_below(place, below.parent_path(), Absent::kMade);
  Descriptor file(::openat(folder.get(), below.filename().c_str(),
                           O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC,
                           kNewFile));
  struct stat status {};
  if (!file || ::fstat(file.get(), &status) != 0) fail(place, errno);
  if (!S_ISREG(status.st_mode) || status.st_nlink != 1 || status.st_uid != ::geteuid()) {
    fail(place, "it is no file of this run");
  }
  return file;
}

void make_result_folder(const ResultPlace& folder) {
  open_below(folder, below_out(folder), Absent::kMade);
}

void remove_result_folder(const ResultPlace& folder) {
  const fs::path below = below_out(folder);
  std::error_code error;
  if (!fs::exists(fs::symlink_status(folder.path().parent_path(), error))) return;
  const Descriptor parent = open_below(folder, below.parent_path(), Absent::kRefused);
  const fs::path opened = "/proc/self/fd/" + std::to_string(parent.get());
  fs::remove_all(opened / below.filename(), error);
  if (error) {
    throw ConfigError(folder.path().string() +
                      " of an earlier run cannot be removed: " + error.message());
  }
}

void remove_result(const ResultPlace& place) {
  const fs::path below = below_out(place);
  std::error_code none;
  if (!fs::exists(fs::symlink_status(place.path().parent_path(), none))) return;
  const Descriptor folder = open_below(place, below.parent_path(), Absent::kRefused);
  if (::unlinkat(folder.get(), below.filename().c_str(), 0) != 0 && errno != ENOENT) {
    throw ConfigError(place.path().string() +
                      " of an earlier run cannot be removed: " + error_text(errno));
  }
}

OpenFile open_result(const ResultPlace& place) {
  Descriptor file = make_result(place);
  OpenFile stream(::fdopen(file.get(), "w"));
  if (!stream) fail(place, errno);
  static_cast<void>(file.release());
  return stream;
}

void close_result(OpenFile file, const ResultPlace& place) {
  int error = std::fflush(file.get()) == 0 ? 0 : errno;
  const bool failed_before = std::ferror(file.get()) != 0;
  if (std::fclose(file.release()) != 0 && error == 0) error = errno;
  if (error == 0 && !failed_before) return;
  throw DiskError(place.path().string() + ": was not written to its end" +
                  (error != 0 ? ": " + error_text(error) : ""));
}

}  // namespace cas::base
