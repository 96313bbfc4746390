// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/udp_peer.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace cas::test {
namespace {

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

}  // namespace

UdpPeer::UdpPeer() {
  fd_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  sockaddr_in address = loopback(0);
  if (::bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
    throw std::runtime_error("no UDP socket");
  }
  const int room_bytes = 4 * 1024 * 1024;
  ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &room_bytes, sizeof room_bytes);
  socklen_t size = sizeof address;
  ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
  port_ = ntohs(address.sin_port);
}

UdpPeer::~UdpPeer() { ::close(fd_); }

std::string UdpPeer::endpoint() const { return "127.0.0.1:" + std::to_string(port_); }

void UdpPeer::send(std::span<const std::uint8_t> bytes) {
  const sockaddr_in to = loopback(remote_);
  ::sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
}

std::size_t UdpPeer::read(PacketStream& into) {
  std::array<std::uint8_t, 4096> buffer;
  std::size_t datagrams = 0;
  for (;;) {
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t count =
        ::recvfrom(fd_, buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (count < 0) return datagrams;
    sender_ = ntohs(from.sin_port);
    into.feed(std::span(buffer).first(static_cast<std::size_t>(count)));
    ++datagrams;
  }
}

std::uint16_t port_of(const std::string& endpoint) {
  return static_cast<std::uint16_t>(std::stoul(endpoint.substr(endpoint.rfind(':') + 1)));
}

}  // namespace cas::test
