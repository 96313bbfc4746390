// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/pty_cable.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

namespace cas::hils {
namespace {

constexpr int kLookForTheEnd_ms = 100;

short events(bool writes) { return static_cast<short>(writes ? POLLIN | POLLOUT : POLLIN); }

}  // namespace

PtyCable::PtyCable(std::filesystem::path first, std::filesystem::path second)
    : first_(std::move(first)), second_(std::move(second)), thread_([this] { carry(); }) {}

PtyCable::~PtyCable() {
  stopping_ = true;
  thread_.join();
}

void PtyCable::carry() {
  Wire there(first_.master(), second_.master());
  Wire back(second_.master(), first_.master());
  while (!stopping_) {
    std::array<pollfd, 2> ends{pollfd{first_.master(), events(back.waiting()), 0},
                               pollfd{second_.master(), events(there.waiting()), 0}};
    if (::poll(ends.data(), ends.size(), kLookForTheEnd_ms) <= 0) continue;
    if ((ends[0].revents & POLLOUT) != 0) back.give();
    if ((ends[1].revents & POLLOUT) != 0) there.give();
    if ((ends[0].revents & POLLIN) != 0) lost_ += there.take();
    if ((ends[1].revents & POLLIN) != 0) lost_ += back.take();
  }
}

std::size_t PtyCable::Wire::take() {
  std::array<char, 4096> chunk;
  const ssize_t size = ::read(from_, chunk.data(), chunk.size());
  if (size <= 0) return 0;
  const auto read = static_cast<std::size_t>(size);
  const std::size_t kept = std::min(read, kMaxWaiting - bytes_.size());
  const bool was_waiting = waiting();
  bytes_.insert(bytes_.end(), chunk.begin(), chunk.begin() + kept);
  if (!was_waiting) give();
  return read - kept;
}

void PtyCable::Wire::give() {
  const ssize_t size = ::write(to_, bytes_.data(), bytes_.size());
  if (size > 0) bytes_.erase(bytes_.begin(), bytes_.begin() + size);
}

}  // namespace cas::hils
