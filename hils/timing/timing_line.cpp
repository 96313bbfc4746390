// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/timing_line.hpp"

#include <poll.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace cas::hils {

namespace {

constexpr std::size_t kReadBytes = 4096;

bool is_passing(int error) { return error == EAGAIN || error == EINTR; }

bool write_unsent(int line, LineProbe& probe) {
  const std::span<const std::uint8_t> bytes = probe.unsent();
  if (bytes.empty()) return true;
  const ssize_t count = ::write(line, bytes.data(), bytes.size());
  if (count < 0) return is_passing(errno);
  probe.sent(static_cast<std::size_t>(count));
  return true;
}

/// @return false: hung up
bool read_line(int line, LineProbe& probe) {
  std::array<std::uint8_t, kReadBytes> buffer;
  const ssize_t count = ::read(line, buffer.data(), buffer.size());
  if (count < 0) return is_passing(errno);
  if (count == 0) return false;
  probe.take(std::span(buffer).first(static_cast<std::size_t>(count)), base::steady_now());
  return true;
}

/// @return whether there is something to read
bool wait(int line, const LineProbe& probe) {
  pollfd entry{line, static_cast<short>(POLLIN | (probe.unsent().empty() ? 0 : POLLOUT)), 0};
  const auto left = std::max(probe.wake() - base::steady_now(), base::Duration{}).count();
  const timespec timeout{static_cast<time_t>(left / 1'000'000'000), left % 1'000'000'000};
  return ::ppoll(&entry, 1, &timeout, nullptr) > 0 &&
         (entry.revents & (POLLIN | POLLHUP | POLLERR)) != 0;
}

}  // namespace

bool run_probe(const base::Descriptor& line, LineProbe& probe) {
  ::prctl(PR_SET_TIMERSLACK, 1UL);  // ns: woken when it is time, not up to 50 us later
  while (!probe.done()) {
    probe.turn(base::steady_now());
    if (!write_unsent(line.get(), probe)) return false;
    if (probe.done()) break;
    if (wait(line.get(), probe) && !read_line(line.get(), probe)) return false;
  }
  return true;
}

}  // namespace cas::hils
