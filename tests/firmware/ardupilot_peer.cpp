// SPDX-License-Identifier: BSD-3-Clause
#include "tests/firmware/ardupilot_peer.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace cas::test {

ArdupilotPeer::ArdupilotPeer(std::uint16_t port, const ScriptedArdupilot::Options& options,
                             const Pilot::Plan& plan)
    : port_(port),
      socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)),
      ardupilot_(std::make_unique<ScriptedArdupilot>(
          options,
          [this](std::span<const std::uint8_t> bytes) {
            said_.push_back({ardupilot_->clock(), {bytes.begin(), bytes.end()}});
            pilot_.on_bytes(bytes, ardupilot_->clock());
          })),
      pilot_(plan, [this](std::span<const std::uint8_t> bytes, std::span<const casd::Path>) {
        ardupilot_->on_ground_bytes(bytes);
      }) {}

ArdupilotPeer::~ArdupilotPeer() { ::close(socket_); }

void ArdupilotPeer::send_packet() {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(port_);
  const auto packet = ardupilot_->servo_packet();
  ::sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
}

std::string ArdupilotPeer::receive(base::Duration patience) {
  pollfd waiting{socket_, POLLIN, 0};
  if (::poll(&waiting, 1, static_cast<int>(patience / std::chrono::milliseconds(1))) <= 0) {
    return {};
  }
  std::array<char, 4096> text;
  const ssize_t size = ::recv(socket_, text.data(), text.size(), 0);
  return {text.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
}

void ArdupilotPeer::pump() {
  // SITL waits about a second, then sends the same packet again.
  send_packet();
  const std::string text = receive(std::chrono::seconds(1));
  if (text.empty()) {
    ++repeats_;
    return;
  }
  ardupilot_->on_text(text);
  pilot_.tick(ardupilot_->clock());
}

}  // namespace cas::test
