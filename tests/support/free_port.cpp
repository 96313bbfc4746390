// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/free_port.hpp"

#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <stdexcept>
#include <string>

namespace cas::test {
namespace {

constexpr unsigned kLeast = 1024;
constexpr unsigned kUsual = 15000;  ///< most services are below
constexpr unsigned kEnough = 5000;

/// Ports outside the range from which the kernel hands them out.
struct Ports {
  unsigned first = kUsual;
  unsigned below = 0;  ///< from `first` on
  unsigned above = 0;  ///< from `first_above` on
  unsigned first_above = 0;

  /// Those below where there are enough, else all.
  unsigned count() const { return below >= kEnough ? below : below + above; }
  std::uint16_t at(unsigned place) const {
    return static_cast<std::uint16_t>(place < below ? first + place : first_above + place - below);
  }
};

Ports ports() {
  unsigned first = 32768;
  unsigned last = 60999;
  std::ifstream("/proc/sys/net/ipv4/ip_local_port_range") >> first >> last;
  const unsigned least = first >= kUsual + kEnough ? kUsual : kLeast;
  return {.first = least,
          .below = first > least ? first - least : 0,
          .above = last < 65535 ? 65535 - last : 0,
          .first_above = last + 1};
}

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

/// Takes a name in the abstract namespace of Unix sockets, which ends with this process or with the
/// descriptor. @return -1 where it is taken
int reserve(std::uint16_t port) {
  const std::string name = "cas-test-port-" + std::to_string(port);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::ranges::copy(name, address.sun_path + 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0) return fd;
  ::close(fd);
  return -1;
}

}  // namespace

std::uint16_t free_port() {
  static unsigned next = static_cast<unsigned>(::getpid());
  static const Ports known = ports();
  for (unsigned tried = 0; tried < known.count(); ++tried) {
    const std::uint16_t port = known.at(next++ % known.count());
    const int reservation = reserve(port);
    if (reservation < 0) continue;
    if (is_free(port, SOCK_DGRAM) && is_free(port, SOCK_STREAM)) return port;
    ::close(reservation);
  }
  throw std::runtime_error("no port is free");
}

}  // namespace cas::test
