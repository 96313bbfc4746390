// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/pty_pair.hpp"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

namespace cas::test {

PtyPair::PtyPair(std::filesystem::path link) : link_(std::move(link)) {
  if (!link_.empty()) lock_.emplace(link_);
  open();
}

PtyPair::~PtyPair() { hang_up(); }

void PtyPair::open() {
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0) {
    throw std::runtime_error("no pseudo-terminal");
  }
  char name[128];
  ::ptsname_r(master_, name, sizeof name);
  slave_ = name;
  keep_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  termios settings{};
  ::tcgetattr(keep_, &settings);
  ::cfmakeraw(&settings);
  ::tcsetattr(keep_, TCSANOW, &settings);
  if (link_.empty()) return;
  lock_->name(keep_);
  std::filesystem::path beside = link_;
  beside += ".new";
  std::filesystem::create_symlink(slave_, beside);
  std::filesystem::rename(beside, link_);
}

void PtyPair::write(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t gone = ::write(master_, bytes.data(), bytes.size());
    if (gone > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(gone));
      continue;
    }
    if (gone < 0 && errno != EAGAIN && errno != EINTR) throw std::runtime_error("line is gone");
    pollfd room{master_, POLLOUT, 0};
    ::poll(&room, 1, 100);
  }
}

std::size_t PtyPair::read(PacketStream& into, std::size_t most) {
  std::vector<std::uint8_t> buffer(most);
  std::size_t total = 0;
  while (total < most) {
    const ssize_t count = ::read(master_, buffer.data(), most - total);
    if (count <= 0) break;
    into.feed({buffer.data(), static_cast<std::size_t>(count)});
    total += static_cast<std::size_t>(count);
  }
  return total;
}

void PtyPair::hang_up() {
  if (master_ < 0) return;
  std::error_code ignored;
  if (!link_.empty()) std::filesystem::remove(link_, ignored);
  if (lock_) lock_->clear();
  ::close(keep_);
  ::close(master_);
  master_ = keep_ = -1;
}

void PtyPair::come_back() {
  hang_up();
  open();
}

}  // namespace cas::test
