// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/socket_address.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstring>
#include <system_error>
#include <thread>

#include "base/os/host_port.hpp"
#include "base/os/lack_of_memory.hpp"

namespace cas::casd {
namespace {

using base::HostPort;

// @return what getaddrinfo says; 0 when `addresses` are filled in
int look_up(const HostPort& parts, int flags, std::vector<SocketAddress>& addresses) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = flags | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(parts.host.c_str(), parts.port.c_str(), &hints, &found);
  if (error != 0) return error;
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
    SocketAddress address;
    std::memcpy(&address.storage, each->ai_addr, each->ai_addrlen);
    address.size = each->ai_addrlen;
    const bool is_new = std::ranges::find(addresses, address) == addresses.end();
    if (is_new && addresses.size() < AddressLookup::kMost) addresses.push_back(address);
  }
  ::freeaddrinfo(found);
  return 0;
}

// A machine without /etc/hosts and name server knows no `localhost`: RFC 6761 section 6.3 does.
int look_up_name(HostPort parts, std::vector<SocketAddress>& addresses) {
  const int error = look_up(parts, AI_ADDRCONFIG, addresses);
  if (error == 0 || parts.host != "localhost") return error;
  parts.host = "127.0.0.1";
  return look_up(parts, AI_NUMERICHOST, addresses);
}

const sockaddr_in& as_ipv4(const SocketAddress& address) {
  return reinterpret_cast<const sockaddr_in&>(address.storage);
}

const sockaddr_in6& as_ipv6(const SocketAddress& address) {
  return reinterpret_cast<const sockaddr_in6&>(address.storage);
}

}  // namespace

std::uint16_t SocketAddress::port() const {
  return ntohs(family() == AF_INET ? as_ipv4(*this).sin_port : as_ipv6(*this).sin6_port);
}

void SocketAddress::set_port(std::uint16_t port) {
  if (family() == AF_INET) {
    reinterpret_cast<sockaddr_in&>(storage).sin_port = htons(port);
  } else {
    reinterpret_cast<sockaddr_in6&>(storage).sin6_port = htons(port);
  }
}

bool SocketAddress::is_multicast() const {
  if (family() == AF_INET) return IN_MULTICAST(ntohl(as_ipv4(*this).sin_addr.s_addr));
  return IN6_IS_ADDR_MULTICAST(&as_ipv6(*this).sin6_addr);
}

bool SocketAddress::is_ipv4_broadcast() const {
  return family() == AF_INET && as_ipv4(*this).sin_addr.s_addr == INADDR_BROADCAST;
}

std::string to_text(const SocketAddress& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address.family() == AF_INET) {
    const sockaddr_in& v4 = as_ipv4(address);
    ::inet_ntop(AF_INET, &v4.sin_addr, text.data(), text.size());
    return fmt::format("{}:{}", text.data(), ntohs(v4.sin_port));
  }
  if (address.family() == AF_INET6) {
    const sockaddr_in6& v6 = as_ipv6(address);
    ::inet_ntop(AF_INET6, &v6.sin6_addr, text.data(), text.size());
    return fmt::format("[{}]:{}", text.data(), ntohs(v6.sin6_port));
  }
  return "?";
}

SocketAddress local_address(int fd) {
  SocketAddress address;
  address.size = sizeof address.storage;
  if (::getsockname(fd, reinterpret_cast<sockaddr*>(&address.storage), &address.size) != 0) {
    address.size = 0;
  }
  return address;
}

std::string to_text(std::span<const int> sockets) {
  std::string text;
  for (const int fd : sockets) text += (text.empty() ? "" : " and ") + to_text(local_address(fd));
  return text;
}

std::vector<int> numbers_of(std::span<const base::Descriptor> sockets) {
  std::vector<int> numbers;
  for (const base::Descriptor& socket : sockets) numbers.push_back(socket.get());
  return numbers;
}

AddressLookup::AddressLookup(const std::string& endpoint) : shared_(std::make_shared<Shared>()) {
  const HostPort parts = base::parse_host_port(endpoint).value_or(HostPort{});
  if (look_up(parts, AI_NUMERICHOST, shared_->addresses) == 0) {
    shared_->state = State::kFound;
    return;
  }
  shared_->is_name = true;
  const auto work = [parts, shared = shared_] {
    State state = State::kFailed;
    const bool done = base::outlive_lack_of_memory("name look-up", [&] {
      const int error = look_up_name(parts, shared->addresses);
      if (error != 0) shared->error = parts.host + ": " + ::gai_strerror(error);
      if (error == 0) state = State::kFound;
    });
    if (!done) shared->error = "no memory";  // short enough to need none
    shared->state.store(state, std::memory_order_release);
  };
  try {
    std::thread(work).detach();
  } catch (const std::system_error& error) {
    shared_->error = parts.host + ": no thread to look it up: " + error.code().message();
    shared_->state = State::kFailed;
  }
}

AddressLookup::State AddressLookup::state() const {
  return shared_ ? shared_->state.load(std::memory_order_acquire) : State::kFailed;
}

const std::vector<SocketAddress>& AddressLookup::addresses() const { return shared_->addresses; }

std::string AddressLookup::error() const { return shared_ ? shared_->error : "no address"; }

}  // namespace cas::casd
