// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/line/pty.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>

#include "base/error.hpp"

namespace cas::fcu {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw base::ConfigError(what + ": " + std::strerror(errno));
}

/// No echo, no line discipline: bytes as they are.
void make_raw(int fd) {
  termios settings{};
  if (::tcgetattr(fd, &settings) != 0) fail("cannot read the terminal's settings");
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  ::cfsetspeed(&settings, B921600);
  if (::tcsetattr(fd, TCSANOW, &settings) != 0) fail("cannot make the terminal raw");
}

}  // namespace

Pty::Pty(std::filesystem::path link) : link_(std::filesystem::absolute(std::move(link))) {
  std::error_code error;
  std::filesystem::create_directories(link_.parent_path(), error);
  if (error) throw base::ConfigError(link_.parent_path().string() + ": " + error.message());
  lock();
  try {
    open();
  } catch (...) {
    ::close(lock_);
    throw;
  }
}

Pty::~Pty() {
  hang_up();
  std::error_code ignored;
  std::filesystem::remove(link_.string() + ".lock", ignored);
  ::close(lock_);
}

void Pty::lock() {
  const std::string name = link_.string() + ".lock";
  lock_ = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (lock_ < 0) fail("cannot open " + name);
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    ::close(lock_);
    throw base::ConfigError(link_.string() + " is offered by another program");
  }
}

void Pty::open() {
  if (master_ >= 0) return;
  try {
    open_pair();
    place_link();
  } catch (...) {
    close_pair();
    throw;
  }
}

void Pty::open_pair() {
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master_ < 0) fail("cannot open a pseudo-terminal");
  if (::grantpt(master_) != 0 || ::unlockpt(master_) != 0) fail("cannot unlock a pseudo-terminal");
  char name[64];
  if (::ptsname_r(master_, name, sizeof(name)) != 0) fail("cannot name a pseudo-terminal");
  slave_name_ = name;
  slave_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (slave_ < 0) fail("cannot open " + slave_name_);
  make_raw(slave_);
}

void Pty::place_link() const {
  std::error_code error;
  const auto status = std::filesystem::symlink_status(link_, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_symlink(status)) {
    throw base::ConfigError(link_.string() + " exists and is no symlink");
  }
  const std::string fresh = link_.string() + "." + std::to_string(::getpid());
  ::unlink(fresh.c_str());
  if (::symlink(slave_name_.c_str(), fresh.c_str()) != 0) fail("cannot create " + fresh);
  if (::rename(fresh.c_str(), link_.c_str()) != 0) fail("cannot rename to " + link_.string());
}

void Pty::hang_up() {
  if (master_ < 0) return;
  std::error_code error;
  if (std::filesystem::read_symlink(link_, error) == slave_name_) {
    std::filesystem::remove(link_, error);
  }
  close_pair();
}

void Pty::close_pair() {
  if (slave_ >= 0) ::close(slave_);
  if (master_ >= 0) ::close(master_);
  slave_ = master_ = -1;
  slave_name_.clear();
}

std::filesystem::path default_link(const std::string& name) {
  if (const char* runtime = std::getenv("XDG_RUNTIME_DIR"); runtime != nullptr && *runtime != 0) {
    return std::filesystem::path(runtime) / "cas" / name;
  }
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("cas-" + std::to_string(::getuid()));
  ::mkdir(folder.c_str(), 0700);
  struct stat info {};
  if (::lstat(folder.c_str(), &info) != 0 || !S_ISDIR(info.st_mode) || info.st_uid != ::getuid() ||
      (info.st_mode & 077) != 0) {
    throw base::ConfigError(folder.string() + " is not a private folder; give --link");
  }
  return folder / name;
}

}  // namespace cas::fcu
