// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <string>

#include "casd/transport/socket_address.hpp"
#include "tests/support/packet_stream.hpp"

namespace cas::test {

/// A UDP socket on any address of this machine, IPv4 or IPv6, that may share its port and join
/// multicast groups on the loopback device.
class AnyUdpPeer {
 public:
  /// @param endpoint  "HOST:PORT" in numbers
  explicit AnyUdpPeer(const std::string& endpoint) {
    const casd::SocketAddress local = address(endpoint);
    fd_ = ::socket(local.family(), SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const int on = 1;
    ::setsockopt(fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    ::setsockopt(fd_, SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
    bound_ = ::bind(fd_, local.get(), local.size) == 0;
  }
  ~AnyUdpPeer() { ::close(fd_); }
  AnyUdpPeer(const AnyUdpPeer&) = delete;
  AnyUdpPeer& operator=(const AnyUdpPeer&) = delete;

  static casd::SocketAddress address(const std::string& endpoint) {
    return casd::AddressLookup(endpoint).address();
  }
  bool bound() const { return bound_; }
  std::string endpoint() const { return casd::to_text(casd::local_address(fd_)); }

  bool join(const char* group) {
    ip_mreqn request{};
    ::inet_pton(AF_INET, group, &request.imr_multiaddr);
    request.imr_ifindex = static_cast<int>(::if_nametoindex("lo"));
    return ::setsockopt(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) == 0 &&
           ::setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_IF, &request, sizeof request) == 0;
  }
  bool send(const std::string& to, std::span<const std::uint8_t> bytes) {
    const casd::SocketAddress remote = address(to);
    return ::sendto(fd_, bytes.data(), bytes.size(), 0, remote.get(), remote.size) ==
           static_cast<ssize_t>(bytes.size());
  }
  void read(PacketStream& into) {
    std::array<std::uint8_t, 4096> buffer;
    for (;;) {
      const ssize_t count = ::recv(fd_, buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (count <= 0) return;
      into.feed(std::span(buffer).first(static_cast<std::size_t>(count)));
    }
  }

 private:
  int fd_ = -1;
  bool bound_ = false;
};

}  // namespace cas::test
