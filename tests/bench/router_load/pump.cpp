// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/pump.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <thread>
#include <vector>

#include "tests/bench/router_load/state.hpp"

namespace router_load {

[[noreturn]] void pump_main(const std::string& slave, int port) {
  int p = open(slave.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK), u = udp_socket(port);
  std::vector<sockaddr_in> gcs;
  for (int i = 0; i < o.gcs; ++i) gcs.push_back(lo_addr(o.gcs_base + i));
  sockaddr_in sim{};
  bool have = false;
  uint8_t b[65536];
  pollfd f[2] = {{p, POLLIN, 0}, {u, POLLIN, 0}};
  for (;;) {
    if (poll(f, 2, -1) < 0) continue;
    if (f[1].revents & POLLIN) {
      socklen_t sl = sizeof sim;
      sockaddr_in from{};
      ssize_t n = recvfrom(u, b, sizeof b, MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &sl);
      int sp = ntohs(from.sin_port);
      if (n > 0 && (sp < o.gcs_base || sp >= o.gcs_base + o.gcs)) {
        sim = from;
        have = true;
        for (ssize_t w = 0; w < n;) {
          ssize_t r = write(p, b + w, size_t(n - w));
          if (r > 0)
            w += r;
          else {
            pollfd q{p, POLLOUT, 0};
            poll(&q, 1, 10);
          }
        }
        for (auto& g : gcs) sendto(u, b, size_t(n), 0, reinterpret_cast<sockaddr*>(&g), sizeof g);
      }
    }
    if (f[0].revents & POLLIN) {
      ssize_t n = read(p, b, 1400);
      // Cut at frame starts would need framing; a datagram may carry a partial frame, so
      // the pump only walks complete MAVLink 2 lengths and keeps the remainder.
      static std::vector<uint8_t> keep;
      if (n > 0) {
        keep.insert(keep.end(), b, b + n);
        size_t i = 0;
        while (keep.size() - i >= 12) {
          if (keep[i] != 0xFD) {
            ++i;
            continue;
          }
          size_t t = size_t(keep[i + 1]) + 12;
          if (keep.size() - i < t) break;
          if (have) sendto(u, &keep[i], t, 0, reinterpret_cast<sockaddr*>(&sim), sizeof sim);
          for (auto& g : gcs) sendto(u, &keep[i], t, 0, reinterpret_cast<sockaddr*>(&g), sizeof g);
          i += t;
        }
        keep.erase(keep.begin(), keep.begin() + long(i));
      }
    }
  }
}

[[noreturn]] void relay_main(const std::string& slave, int port) {
  const int line = open(slave.c_str(), O_RDWR | O_NOCTTY);
  const int socket = udp_socket(port);
  fcntl(socket, F_SETFL, fcntl(socket, F_GETFL) & ~O_NONBLOCK);
  // Down knows the simulator after its first datagram and connects the socket for up.
  std::thread([=] {
    std::array<std::uint8_t, 65536> bytes;
    bool connected = false;
    for (;;) {
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t count = recvfrom(socket, bytes.data(), bytes.size(), 0,
                                     reinterpret_cast<sockaddr*>(&from), &size);
      if (count <= 0) continue;
      if (!connected) {
        connected = connect(socket, reinterpret_cast<const sockaddr*>(&from), size) == 0;
      }
      for (ssize_t gone = 0; gone < count;) {
        const ssize_t now =
            write(line, bytes.data() + gone, static_cast<std::size_t>(count - gone));
        if (now < 0 && errno != EINTR) _exit(1);
        gone += std::max<ssize_t>(now, 0);
      }
    }
  }).detach();
  std::array<std::uint8_t, 1400> bytes;
  for (;;) {
    const ssize_t count = read(line, bytes.data(), bytes.size());
    if (count <= 0 && errno != EINTR) _exit(1);
    if (count > 0) send(socket, bytes.data(), static_cast<std::size_t>(count), MSG_NOSIGNAL);
  }
}

}  // namespace router_load
