// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/rpc/message.hpp"
#include "base/time/clock.hpp"

namespace cas::base::rpc {

/// A client that sends any bytes and reads lines, with a deadline on all it does.
class RawClient {
 public:
  /// @param from  the client's own address, within 127.0.0.0/8
  explicit RawClient(std::uint16_t port, const char* from = "127.0.0.1")
      : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    EXPECT_EQ(::inet_pton(AF_INET, from, &address.sin_addr), 1);
    const int on = 1;  // takes the port in connect(): thousands of clients may follow each other
    ::setsockopt(fd_, IPPROTO_IP, IP_BIND_ADDRESS_NO_PORT, &on, sizeof on);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  /// On a Unix socket.
  explicit RawClient(const std::string& path)
      : fd_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0)
        << path;
  }
  ~RawClient() { close(); }
  RawClient(RawClient&& other) noexcept
      : fd_(std::exchange(other.fd_, -1)), rx_(std::move(other.rx_)) {}
  RawClient& operator=(RawClient&&) = delete;

  void close() {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  }
  void end_of_input() { ::shutdown(fd_, SHUT_WR); }

  /// @return false when the server closed or took nothing in time
  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      if (!wait_for(POLLOUT)) return false;
      const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0 && errno == EAGAIN) continue;
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }

  /// The next line, or nothing when the server closed or sent none in time.
  std::optional<std::string> line() {
    while (true) {
      const std::size_t newline = rx_.find('\n');
      if (newline != std::string::npos) {
        std::string text = rx_.substr(0, newline);
        rx_.erase(0, newline + 1);
        return text;
      }
      if (!receive()) return std::nullopt;
    }
  }
  Json json() {
    const std::optional<std::string> text = line();
    EXPECT_TRUE(text.has_value()) << "no line came";
    return text ? Json::parse(*text) : Json();
  }
  /// Sends one line and reads the answer.
  Json ask(const std::string& text) {
    EXPECT_TRUE(send(text + "\n"));
    return json();
  }
  /// True when the server ends the connection; drops its remaining data.
  bool closed_by_server() {
    while (receive()) rx_.clear();
    return ended_;
  }

 private:
  bool wait_for(short events) {
    pollfd entry{fd_, events, 0};
    return ::poll(&entry, 1, 20'000) > 0;
  }
  bool receive() {
    char buffer[65536];
    if (!wait_for(POLLIN)) return false;
    const ssize_t size = ::recv(fd_, buffer, sizeof buffer, 0);
    if (size <= 0) {
      ended_ = true;
      return false;
    }
    rx_.append(buffer, static_cast<std::size_t>(size));
    return true;
  }

  int fd_;
  std::string rx_;
  bool ended_ = false;
};

}  // namespace cas::base::rpc
