// SPDX-License-Identifier: BSD-3-Clause
#include "hils/pty_relay.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <utility>

namespace cas::hils {
namespace {

constexpr int kLookForTheEnd_ms = 100;

void pass(int from, int to) {
  std::array<char, 4096> bytes;
  const ssize_t size = ::read(from, bytes.data(), bytes.size());
  if (size <= 0) return;
  [[maybe_unused]] const auto taken = ::write(to, bytes.data(), static_cast<std::size_t>(size));
}

}  // namespace

PtyRelay::PtyRelay(std::filesystem::path first, std::filesystem::path second)
    : first_(std::move(first)), second_(std::move(second)), thread_([this] { carry(); }) {}

PtyRelay::~PtyRelay() {
  stopping_ = true;
  thread_.join();
}

void PtyRelay::carry() {
  while (!stopping_) {
    std::array<pollfd, 2> ends{pollfd{first_.master(), POLLIN, 0},
                               pollfd{second_.master(), POLLIN, 0}};
    if (::poll(ends.data(), ends.size(), kLookForTheEnd_ms) <= 0) continue;
    if ((ends[0].revents & POLLIN) != 0) pass(ends[0].fd, ends[1].fd);
    if ((ends[1].revents & POLLIN) != 0) pass(ends[1].fd, ends[0].fd);
  }
}

}  // namespace cas::hils
