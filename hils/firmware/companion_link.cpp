// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/companion_link.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <array>

#include "base/error.hpp"

namespace cas::hils {
namespace {

constexpr int kTickMs = 20;

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

sockaddr* generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

}  // namespace

CompanionLink::CompanionLink()
    : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  sockaddr_in here = loopback(0);
  socklen_t size = sizeof here;
  if (!socket_ || !stop_ || ::bind(socket_.get(), generic(here), size) != 0 ||
      ::getsockname(socket_.get(), generic(here), &size) != 0) {
    throw base::ConfigError("cannot open a UDP port for setpoints and missions");
  }
  port_ = ntohs(here.sin_port);
}

CompanionLink::~CompanionLink() {
  if (!connected()) return;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(stop_.get(), &one, sizeof(one));
  thread_.join();
}

void CompanionLink::connect(std::uint16_t casd_port, mav::Source vehicle) {
  sockaddr_in casd = loopback(casd_port);
  if (::connect(socket_.get(), generic(casd), sizeof casd) != 0) {
    throw base::ConfigError("cannot reach casd's port for setpoints and missions");
  }
  {
    base::MutexLock lock(mutex_);
    station_.emplace(vehicle, [this](std::span<const std::uint8_t> packet) {
      // A datagram that casd does not take is lost, as on any link.
      [[maybe_unused]] const auto sent = ::send(socket_.get(), packet.data(), packet.size(), 0);
    });
  }
  thread_ = std::thread([this] { run(); });
}

void CompanionLink::run() {
  std::array<std::uint8_t, 2048> buffer{};
  while (true) {
    std::array<pollfd, 2> ends{pollfd{socket_.get(), POLLIN, 0}, pollfd{stop_.get(), POLLIN, 0}};
    ::poll(ends.data(), ends.size(), kTickMs);
    if (ends[1].revents != 0) return;
    base::MutexLock lock(mutex_);
    while (true) {
      const ssize_t received = ::recv(socket_.get(), buffer.data(), buffer.size(), 0);
      if (received <= 0) break;
      station_->on_bytes(std::span(buffer).first(static_cast<std::size_t>(received)),
                         base::steady_now());
    }
    station_->tick(base::steady_now());
  }
}

}  // namespace cas::hils
