// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>
#include <string>

#include "base/config/config.hpp"
#include "base/time/clock.hpp"

namespace cas::sim {

/// An IPv4 or IPv6 address with port, for the sockets of plugins that speak UDP or TCP.
class InetAddress {
 public:
  InetAddress() = default;
  /// "127.0.0.1:14560", "[::1]:14560" or "host:14560". @throws base::ConfigError through `node`
  static InetAddress parse(const base::ConfigNode& node);
  /// A port of this machine's IPv4 loopback.
  static InetAddress loopback(std::uint16_t port);

  std::string text() const;
  int family() const { return storage_.ss_family; }
  const sockaddr* data() const { return reinterpret_cast<const sockaddr*>(&storage_); }
  sockaddr* data() { return reinterpret_cast<sockaddr*>(&storage_); }
  socklen_t size() const { return size_; }
  void set_size(socklen_t size) { size_ = size; }
  friend bool operator==(const InetAddress& a, const InetAddress& b);

 private:
  sockaddr_storage storage_{};
  socklen_t size_ = sizeof(sockaddr_storage);
};

/// The address a socket is bound to, as text; "?" if unknown.
std::string bound_address(int socket);

/// Waits until one of the sockets is readable. Sockets below 0 are left out.
/// @return false after `timeout` or on a signal
bool wait_readable(int socket, int other_socket, base::Duration timeout);

}  // namespace cas::sim
