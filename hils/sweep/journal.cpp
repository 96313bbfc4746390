// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace cas::hils {

namespace {

[[noreturn]] void fail_journal(const std::filesystem::path& file, const std::string& what) {
  throw base::ConfigError(file.string() + ": " + what + ": " + std::strerror(errno));
}

/// Bytes up to the end of the last whole line.
off_t whole_lines(int fd, off_t size) {
  std::array<char, 4096> buffer{};
  while (size > 0) {
    const off_t begin = size > static_cast<off_t>(buffer.size())
                            ? size - static_cast<off_t>(buffer.size())
                            : off_t{0};
    const ssize_t got = ::pread(fd, buffer.data(), static_cast<std::size_t>(size - begin), begin);
    if (got <= 0) return size;
    const std::size_t at =
        std::string_view(buffer.data(), static_cast<std::size_t>(got)).rfind('\n');
    if (at != std::string_view::npos) return begin + static_cast<off_t>(at) + 1;
    size = begin;
  }
  return 0;
}

}  // namespace

Journal::Journal(const std::filesystem::path& file)
    : file_(file),
      out_(::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0644)) {
  if (!out_) fail_journal(file, "cannot be written");
  if (::flock(out_.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) fail_journal(file, "cannot be locked");
    throw base::ConfigError(file.string() + ": another process flies this part of the sweep");
  }
  struct stat now {};
  if (::fstat(out_.get(), &now) != 0) fail_journal(file, "cannot be read");
  const off_t whole = whole_lines(out_.get(), now.st_size);
  if (whole != now.st_size && ::ftruncate(out_.get(), whole) != 0)
    fail_journal(file, "cannot be cut");
  const base::Descriptor folder(
      ::open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder) ::fsync(folder.get());  // the journal's name is on the disk
}

void Journal::append(const RowResult& result) {
  const std::string line = journal_line(result);
  std::string_view rest = line;
  while (!rest.empty()) {
    const ssize_t written = ::write(out_.get(), rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail_journal(file_, "cannot be written");
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::fdatasync(out_.get()) != 0) fail_journal(file_, "cannot be written");
}

}  // namespace cas::hils
