// SPDX-License-Identifier: BSD-3-Clause
#include "tests/firmware/px4_sitl_peer.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace cas::test {

Px4SitlPeer::Px4SitlPeer(std::uint16_t port, const ScriptedPx4::Options& options,
                         const Pilot::Plan& plan)
    : port_(port),
      px4_(std::make_unique<ScriptedPx4>(
          options,
          [this](std::span<const std::uint8_t> bytes) {
            if (!deaf_) ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
          },
          [this](std::span<const std::uint8_t> bytes) {
            said_.push_back({px4_->clock(), {bytes.begin(), bytes.end()}});
            pilot_.on_bytes(bytes, px4_->clock());
          })),
      pilot_(plan, [this](std::span<const std::uint8_t> bytes, std::span<const casd::Path>) {
        px4_->on_ground_bytes(bytes, px4_->clock());
      }) {}

void Px4SitlPeer::disconnect() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

bool Px4SitlPeer::connect() {
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(port_);
  if (::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to) != 0) {
    disconnect();
    return false;
  }
  const int on = 1;
  setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  px4_->on_connected();
  return true;
}

void Px4SitlPeer::pump() {
  constexpr int kMilliseconds = 20;
  if (socket_ < 0 && !connect()) {
    ::poll(nullptr, 0, 1);
    return;
  }
  pollfd waiting{socket_, POLLIN, 0};
  if (::poll(&waiting, 1, kMilliseconds) <= 0) return;
  std::array<std::uint8_t, 4096> bytes;
  const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), 0);
  if (size <= 0) return disconnect();
  px4_->on_simulator_bytes(std::span(bytes).first(static_cast<std::size_t>(size)), px4_->clock());
  pilot_.tick(px4_->clock());
}

}  // namespace cas::test
