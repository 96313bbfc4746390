// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/free_port.hpp"

#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace cas::test {
namespace {

constexpr unsigned kFirst = 15000;
constexpr unsigned kCount = 17000;  // up to 31999: Linux hands out 32768 and above

bool is_free(std::uint16_t port, int kind) {
  const int fd = ::socket(AF_INET, kind | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  address.sin_port = htons(port);
  const bool bound = ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(fd);
  return bound;
}

/// Takes a name in the abstract namespace of Unix sockets, which ends with this process.
bool reserve(std::uint16_t port) {
  const std::string name = "cas-test-port-" + std::to_string(port);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::ranges::copy(name, address.sun_path + 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0) return true;
  ::close(fd);
  return false;
}

}  // namespace

std::uint16_t free_port() {
  static unsigned next = static_cast<unsigned>(::getpid());
  for (unsigned tried = 0; tried < kCount; ++tried) {
    const auto port = static_cast<std::uint16_t>(kFirst + next++ % kCount);
    if (reserve(port) && is_free(port, SOCK_DGRAM) && is_free(port, SOCK_STREAM)) return port;
  }
  throw std::runtime_error("no port is free");
}

}  // namespace cas::test
