// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/inet_address.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <poll.h>

#include <array>
#include <cstring>
#include <ctime>
#include <optional>

#include "base/os/host_port.hpp"

namespace cas::sim {

InetAddress InetAddress::parse(const base::ConfigNode& node) {
  const auto text = node.as<std::string>();
  const std::optional<base::HostPort> parts = base::parse_host_port(text);
  if (!parts) node.fail("must be an address and port, HOST:PORT");
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(parts->host.c_str(), parts->port.c_str(), &hints, &found);
  if (error != 0) node.fail(std::string("is no address: ") + gai_strerror(error));
  InetAddress address;
  std::memcpy(&address.storage_, found->ai_addr, found->ai_addrlen);
  address.size_ = found->ai_addrlen;
  freeaddrinfo(found);
  return address;
}

std::string InetAddress::text() const {
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  if (getnameinfo(data(), size_, host.data(), host.size(), port.data(), port.size(),
                  NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return "?";
  }
  std::string text;
  const bool bracketed = family() == AF_INET6;
  if (bracketed) text += '[';
  text += host.data();
  if (bracketed) text += ']';
  text += ':';
  text += port.data();
  return text;
}

bool operator==(const InetAddress& a, const InetAddress& b) {
  if (a.family() != b.family()) return false;
  if (a.family() == AF_INET) {
    const auto& left = reinterpret_cast<const sockaddr_in&>(a.storage_);
    const auto& right = reinterpret_cast<const sockaddr_in&>(b.storage_);
    return left.sin_port == right.sin_port && left.sin_addr.s_addr == right.sin_addr.s_addr;
  }
  const auto& left = reinterpret_cast<const sockaddr_in6&>(a.storage_);
  const auto& right = reinterpret_cast<const sockaddr_in6&>(b.storage_);
  return left.sin6_port == right.sin6_port &&
         std::memcmp(&left.sin6_addr, &right.sin6_addr, sizeof left.sin6_addr) == 0;
}

InetAddress InetAddress::loopback(std::uint16_t port) {
  InetAddress address;
  auto& v4 = reinterpret_cast<sockaddr_in&>(address.storage_);
  v4.sin_family = AF_INET;
  v4.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  v4.sin_port = htons(port);
  address.size_ = sizeof v4;
  return address;
}

std::string bound_address(int socket) {
  InetAddress bound;
  socklen_t size = bound.size();
  if (getsockname(socket, bound.data(), &size) != 0) return "?";
  bound.set_size(size);
  return bound.text();
}

bool wait_readable(int socket, int other_socket, base::Duration timeout) {
  std::array<pollfd, 2> waiting{pollfd{socket, POLLIN, 0}, pollfd{other_socket, POLLIN, 0}};
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(timeout);
  const timespec limit{static_cast<time_t>(whole.count()),
                       static_cast<long>((timeout - whole).count())};
  return ppoll(waiting.data(), waiting.size(), &limit, nullptr) > 0;
}

}  // namespace cas::sim
