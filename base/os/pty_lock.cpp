// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/pty_lock.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <string>
#include <string_view>
#include <system_error>

#include "base/error.hpp"
#include "base/os/command_port.hpp"
#include "base/os/file_lock.hpp"

namespace cas::base {
namespace {

// Fixed length of the record, so that a new one overwrites the old one completely.
constexpr std::size_t kRecordBytes = 64;

std::filesystem::path lock_file(std::filesystem::path link) { return link += ".lock"; }

[[noreturn]] void fail(const std::filesystem::path& file) {
  throw ConfigError(file.string() + ": " + error_text(errno));
}

bool is_at(int fd, const std::filesystem::path& file) {
  struct stat open {};
  struct stat named {};
  return ::fstat(fd, &open) == 0 && ::lstat(file.c_str(), &named) == 0 &&
         open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

std::string record(const PtyIdentity& identity) {
  std::string text = "pty " + std::to_string(identity.device) + " changed_ns " +
                     std::to_string(identity.changed_ns);
  text.resize(kRecordBytes - 1, ' ');
  return text + '\n';
}

/// The number behind `word`; 0 when it is not there.
template <class Number>
Number number_behind(std::string_view text, std::string_view word) {
  Number number = 0;
  const std::size_t at = text.find(word);
  if (at != std::string_view::npos) {
    std::from_chars(text.data() + at + word.size(), text.data() + text.size(), number);
  }
  return number;
}

std::string read_text(int fd) {
  std::array<char, kRecordBytes> bytes{};
  const ssize_t size = ::pread(fd, bytes.data(), bytes.size(), 0);
  return {bytes.data(), size > 0 ? static_cast<std::size_t>(size) : 0};
}

PtyIdentity read_record(int fd) {
  const std::string text = read_text(fd);
  return {.device = number_behind<std::uint64_t>(text, "pty "),
          .changed_ns = number_behind<std::int64_t>(text, "changed_ns ")};
}

/// Whether it is a lock file, old or new, and not some file of that name ("poetry.lock").
bool may_be_replaced(int fd) {
  struct stat file {};
  if (::fstat(fd, &file) != 0 || !S_ISREG(file.st_mode) || file.st_nlink > 1) return false;
  return file.st_size == 0 || read_text(fd).starts_with("pty ");
}

bool may_vouch(uid_t owner, const struct stat& slave) {
  return owner == 0 || owner == slave.st_uid || owner == ::geteuid();
}

PtyOffer offer_beside(const std::filesystem::path& link, int slave) {
  const Descriptor lock(
      ::open(lock_file(link).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  struct stat file {};
  struct stat terminal {};
  if (!lock || ::fstat(lock.get(), &file) != 0 || ::fstat(slave, &terminal) != 0) {
    return PtyOffer::kNone;
  }
  if (!S_ISREG(file.st_mode) || !may_vouch(file.st_uid, terminal)) return PtyOffer::kNone;
  // Read before testing the lock: the owner clears the record while it still holds the lock.
  const PtyIdentity named = read_record(lock.get());
  if (!is_file_locked(lock.get())) return PtyOffer::kNone;
  return identify_pty(slave) == named ? PtyOffer::kThis : PtyOffer::kOther;
}

}  // namespace

std::optional<PtyIdentity> identify_pty(int fd) {
  constexpr unsigned kFirstMajor = 136;  // UNIX98_PTY_SLAVE_MAJOR and the seven after it
  constexpr unsigned kMajors = 8;
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  struct stat status {};
  if (::fstat(fd, &status) != 0 || !S_ISCHR(status.st_mode)) return std::nullopt;
  const unsigned number = major(status.st_rdev);
  if (number < kFirstMajor || number >= kFirstMajor + kMajors) return std::nullopt;
  return PtyIdentity{.device = status.st_rdev,
                     .changed_ns = status.st_ctim.tv_sec * kSecond_ns + status.st_ctim.tv_nsec};
}

PtyLock::PtyLock(const std::filesystem::path& link) : file_(lock_file(link)) {
  constexpr mode_t kReadable = 0644;  // casd may be another user
  do {
    lock_ = Descriptor(
        ::open(file_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NOCTTY | O_CLOEXEC, kReadable));
    if (!lock_) fail(file_);
    if (!take_file_lock(lock_.get())) {
      throw CommandPortError(link.string() + " is offered by another program");
    }
    // The last owner may have unlinked the file between open and lock: then try again.
  } while (!is_at(lock_.get(), file_));
  if (!may_be_replaced(lock_.get())) {
    throw ConfigError(file_.string() + ": is no lock of a pseudo-terminal; " + link.string() +
                      " cannot be offered beside it");
  }
  ::fchmod(lock_.get(), kReadable);
  if (::ftruncate(lock_.get(), 0) != 0) fail(file_);
}

PtyLock::~PtyLock() {
  if (is_at(lock_.get(), file_)) ::unlink(file_.c_str());  // not another program's
}

void PtyLock::name(int slave) {
  const std::optional<PtyIdentity> identity = identify_pty(slave);
  CAS_CHECK(identity.has_value());
  if (*identity != named_) write(*identity);
}

void PtyLock::clear() noexcept {
  named_ = {};
  // Should it fail, the old record does no harm: its device and time of change never come again.
  [[maybe_unused]] const int result = ::ftruncate(lock_.get(), 0);
}

void PtyLock::write(const PtyIdentity& identity) {
  const std::string text = record(identity);
  const ssize_t written = ::pwrite(lock_.get(), text.data(), text.size(), 0);
  if (written != static_cast<ssize_t>(text.size())) fail(file_);
  named_ = identity;
}

PtyOffer pty_offer(std::filesystem::path path, int slave) {
  constexpr int kMostLinks = 8;
  PtyOffer offer = PtyOffer::kNone;
  for (int i = 0; i < kMostLinks; ++i) {
    offer = std::max(offer, offer_beside(path, slave));
    std::error_code none;
    const std::filesystem::path next = std::filesystem::read_symlink(path, none);
    if (none || offer == PtyOffer::kThis) break;
    path = path.parent_path() / next;  // an absolute path replaces the whole
  }
  return offer;
}

}  // namespace cas::base
