// SPDX-License-Identifier: BSD-3-Clause
// A serial line or pseudo-terminal for the examples. The library itself opens nothing.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <span>

class Line {
 public:
  explicit Line(const char* device) : fd_(::open(device, O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    termios settings{};
    if (::tcgetattr(fd_, &settings) != 0) return;
    ::cfmakeraw(&settings);
    ::tcsetattr(fd_, TCSANOW, &settings);
  }
  ~Line() { ::close(fd_); }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  bool is_open() const { return fd_ >= 0; }
  /// Sends a packet; one that the line has no room for is lost, as on a radio.
  void send(std::span<const std::uint8_t> packet) const {
    if (::write(fd_, packet.data(), packet.size()) < 0) return;
  }
  /// Bytes that come within 20 ms; valid until the next call.
  std::span<const std::uint8_t> read() {
    pollfd readable{fd_, POLLIN, 0};
    ::poll(&readable, 1, 20);
    const ssize_t size = ::read(fd_, bytes_.data(), bytes_.size());
    return std::span(bytes_).first(size > 0 ? static_cast<std::size_t>(size) : 0);
  }

 private:
  int fd_;
  std::array<std::uint8_t, 4096> bytes_{};
};
