// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/emulator/served_folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <system_error>

#include "base/error.hpp"

namespace cas::fcu {

namespace fs = std::filesystem;
using mav::services::FtpEntry;
using mavlink::common::MavFtpErr;

namespace {

constexpr ServedFolder::Failure kNotFound{.code = MavFtpErr::kFilenotfound};

constexpr std::size_t kMaxEntries = 8192;  // of a folder, as a client takes at most

ServedFolder::Failure failed(int error_number) {
  return {.code = MavFtpErr::kFailerrno, .error_number = static_cast<std::uint8_t>(error_number)};
}

/// As the protocol can tell it.
std::uint32_t told(std::uintmax_t size) {
  constexpr std::uintmax_t kMost = std::numeric_limits<std::uint32_t>::max();
  return static_cast<std::uint32_t>(std::min(size, kMost));
}

/// A regular file, open for reading.
class OpenFile {
 public:
  explicit OpenFile(const std::optional<fs::path>& file) {
    if (!file) return;
    // If a symlink or FIFO has replaced the file meanwhile, do not follow it or block on it.
    fd_ = ::open(file->c_str(), O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
    if (fd_ < 0 || ::fstat(fd_, &status_) != 0) {
      failure_ = failed(errno);
    } else if (S_ISREG(status_.st_mode)) {
      failure_ = {};
    }
  }
  ~OpenFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  const ServedFolder::Failure& failure() const { return failure_; }
  int fd() const { return fd_; }
  std::uint32_t length() const { return told(static_cast<std::uintmax_t>(status_.st_size)); }

 private:
  int fd_ = -1;
  struct stat status_ {};
  ServedFolder::Failure failure_ = kNotFound;
};

}  // namespace

ServedFolder::ServedFolder(const fs::path& folder) {
  std::error_code error;
  folder_ = fs::canonical(folder, error);
  if (error || !fs::is_directory(folder_, error)) {
    throw base::ConfigError("--files: there is no folder " + folder.string());
  }
}

/// Where a path leads. @return nullopt when that is not inside the folder, or not there
std::optional<fs::path> ServedFolder::inside(const fs::path& path) const {
  std::error_code error;
  fs::path real = fs::canonical(folder_ / path, error);
  if (error) return std::nullopt;
  const auto [end, rest] = std::mismatch(folder_.begin(), folder_.end(), real.begin(), real.end());
  return end == folder_.end() ? std::optional(std::move(real)) : std::nullopt;
}

ServedFolder::Failure ServedFolder::list(const std::string& folder,
                                         std::vector<FtpEntry>& entries) {
  const auto real = inside(folder);
  std::error_code error;
  if (!real || !fs::is_directory(*real, error)) return kNotFound;
  for (fs::directory_iterator each(*real, error), end;
       !error && each != end && entries.size() < kMaxEntries; each.increment(error)) {
    std::error_code gone;
    const bool hidden = each->is_symlink(gone) && !inside(each->path());
    const std::string name = each->path().filename().string();
    if (hidden) continue;
    if (each->is_directory(gone)) {
      entries.push_back({.folder = true, .name = name});
    } else if (each->is_regular_file(gone)) {
      const std::uintmax_t size = each->file_size(gone);
      entries.push_back({.name = name, .size = gone ? 0 : told(size)});
    }
  }
  if (error) return failed(error.value());
  std::ranges::sort(entries, {}, &FtpEntry::name);
  return {};
}

ServedFolder::Failure ServedFolder::length(const std::string& path, std::uint32_t& bytes) {
  const OpenFile file(inside(path));
  if (!file.failure().failed()) bytes = file.length();
  return file.failure();
}

ServedFolder::Failure ServedFolder::read(const std::string& path, std::uint32_t offset,
                                         std::span<std::uint8_t>& out) {
  const OpenFile file(inside(path));
  if (file.failure().failed()) return file.failure();
  const ssize_t size = ::pread(file.fd(), out.data(), out.size(), offset);
  if (size < 0) return failed(errno);
  out = out.first(static_cast<std::size_t>(size));
  return {};
}

}  // namespace cas::fcu
