// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/pty.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "base/error.hpp"
#include "base/os/serial_settings.hpp"

namespace cas::base {
namespace {

constexpr unsigned kShownBaud = 921'600;  // nothing paces a pseudo-terminal

[[noreturn]] void fail_with_errno(const std::string& what) {
  throw ConfigError(what + ": " + std::strerror(errno));
}

/// The path itself, once its folder has been made.
std::filesystem::path in_a_folder(std::filesystem::path link) {
  std::error_code error;
  std::filesystem::create_directories(link.parent_path(), error);
  if (error) throw ConfigError(link.parent_path().string() + ": " + error.message());
  return link;
}

}  // namespace

Pty::Pty(std::filesystem::path link)
    : link_(in_a_folder(std::filesystem::absolute(link))), lock_(link_) {
  open();
}

Pty::~Pty() { hang_up(); }

void Pty::open() {
  if (master_ >= 0) return;
  try {
    open_pair();
    lock_.name(slave_);  // before the symlink exists: a finder reads the name
    place_link();
  } catch (...) {
    close_pair();
    throw;
  }
}

void Pty::open_pair() {
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master_ < 0) fail_with_errno("cannot open a pseudo-terminal");
  if (::grantpt(master_) != 0 || ::unlockpt(master_) != 0)
    fail_with_errno("cannot unlock a pseudo-terminal");
  char name[64];
  if (::ptsname_r(master_, name, sizeof(name)) != 0)
    fail_with_errno("cannot name a pseudo-terminal");
  slave_name_ = name;
  slave_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (slave_ < 0) fail_with_errno("cannot open " + slave_name_);
  if (!make_serial_raw(slave_, kShownBaud)) fail_with_errno("cannot make the terminal raw");
}

void Pty::place_link() const {
  std::error_code error;
  const auto status = std::filesystem::symlink_status(link_, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_symlink(status)) {
    throw ConfigError(link_.string() + " exists and is no symlink");
  }
  const std::string fresh = link_.string() + "." + std::to_string(::getpid());
  ::unlink(fresh.c_str());
  if (::symlink(slave_name_.c_str(), fresh.c_str()) != 0) fail_with_errno("cannot create " + fresh);
  if (::rename(fresh.c_str(), link_.c_str()) != 0)
    fail_with_errno("cannot rename to " + link_.string());
}

void Pty::hang_up() {
  if (master_ < 0) return;
  std::error_code error;
  if (std::filesystem::read_symlink(link_, error) == slave_name_) {
    std::filesystem::remove(link_, error);
  }
  close_pair();
}

void Pty::refresh_lock() {
  if (slave_ >= 0) lock_.name(slave_);
}

void Pty::close_pair() {
  lock_.clear();  // first: another program may get this number at once
  if (slave_ >= 0) ::close(slave_);
  if (master_ >= 0) ::close(master_);
  slave_ = master_ = -1;
  slave_name_.clear();
}

}  // namespace cas::base
