// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "plugins/common/inet_address.hpp"

namespace cas::sim {

/// The UDP socket that ArduPilot's SITL sends to. Answers go to wherever the last datagram came
/// from: the firmware's port is a new one after each start.
class JsonLink {
 public:
  /// @throws std::system_error when the address cannot be bound
  explicit JsonLink(const InetAddress& local);
  ~JsonLink();
  JsonLink(const JsonLink&) = delete;
  JsonLink& operator=(const JsonLink&) = delete;

  /// Waits for a datagram. @return false after `timeout` or on a signal
  bool wait(base::Duration timeout) { return wait_readable(socket_, -1, timeout); }
  /// The next datagram that is there; the view lives until the next call.
  std::optional<std::span<const std::uint8_t>> receive();
  /// To the sender of the last datagram. @return false when it was not taken
  bool send(std::string_view text);
  std::string endpoint() const { return "udp " + bound_address(socket_); }
  std::string peer() const { return peer_ ? peer_->text() : std::string(); }

 private:
  int socket_ = -1;
  std::optional<InetAddress> peer_;
  std::array<std::uint8_t, 512> buffer_{};
};

}  // namespace cas::sim
