// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/ground_station_thread.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <array>
#include <utility>

#include "base/error.hpp"

namespace cas::hils {

namespace {

sockaddr* generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

}  // namespace

GroundStationThread::GroundStationThread(std::vector<std::uint8_t> systems)
    : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      systems_(std::move(systems)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  if (!socket_ || !stop_ || ::bind(socket_.get(), generic(address), size) != 0 ||
      ::getsockname(socket_.get(), generic(address), &size) != 0) {
    throw base::ConfigError("cannot open a UDP port for the ground station");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { run(); });
}

GroundStationThread::~GroundStationThread() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(stop_.get(), &one, sizeof(one));
  thread_.join();
}

void GroundStationThread::run() {
  sockaddr_in peer{};
  GroundStation station(systems_, kParameterListPeriod, [&](std::span<const std::uint8_t> bytes) {
    if (peer.sin_port == 0) return;  // nobody has written yet
    ::sendto(socket_.get(), bytes.data(), bytes.size(), 0, generic(peer), sizeof(peer));
  });
  std::array<std::uint8_t, 2048> buffer{};
  constexpr int kTickMs =
      static_cast<int>(GroundStation::kTickPeriod / std::chrono::milliseconds(1));
  while (true) {
    std::array<pollfd, 2> fds{pollfd{socket_.get(), POLLIN, 0}, pollfd{stop_.get(), POLLIN, 0}};
    ::poll(fds.data(), fds.size(), kTickMs);
    if (fds[1].revents != 0) return;
    while (true) {
      socklen_t size = sizeof(peer);
      const ssize_t received =
          ::recvfrom(socket_.get(), buffer.data(), buffer.size(), 0, generic(peer), &size);
      if (received <= 0) break;
      station.on_bytes(std::span(buffer).first(static_cast<std::size_t>(received)));
    }
    station.flood(flood_hz_);
    station.tick(base::steady_now());
  }
}

}  // namespace cas::hils
