// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run/loopback_udp.hpp"

#include <sys/socket.h>

#include "base/error.hpp"

namespace cas::hils {
namespace {

constexpr std::size_t kLargestDatagram = 65536;

sockaddr* generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

}  // namespace

LoopbackUdp::LoopbackUdp(const std::string& failure)
    : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  sockaddr_in here = loopback(0);
  socklen_t size = sizeof(here);
  if (!socket_ || ::bind(socket_.get(), generic(here), size) != 0 ||
      ::getsockname(socket_.get(), generic(here), &size) != 0) {
    throw base::ConfigError(failure);
  }
  port_ = ntohs(here.sin_port);
}

bool LoopbackUdp::connect(std::uint16_t port) {
  peer_ = loopback(port);
  return ::connect(socket_.get(), generic(peer_), sizeof(peer_)) == 0;
}

void LoopbackUdp::send(std::span<const std::uint8_t> bytes) {
  if (peer_.sin_port == 0) return;
  [[maybe_unused]] const auto sent =
      ::sendto(socket_.get(), bytes.data(), bytes.size(), 0, generic(peer_), sizeof(peer_));
}

std::span<const std::uint8_t> LoopbackUdp::read() {
  buffer_.resize(kLargestDatagram);
  sockaddr_in from{};
  socklen_t size = sizeof(from);
  const ssize_t got =
      ::recvfrom(socket_.get(), buffer_.data(), buffer_.size(), 0, generic(from), &size);
  if (got <= 0) return {};
  peer_ = from;
  return std::span(buffer_).first(static_cast<std::size_t>(got));
}

}  // namespace cas::hils
