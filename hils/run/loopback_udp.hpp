// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/os/descriptor.hpp"

namespace cas::hils {

/// A non-blocking UDP socket on a free port of 127.0.0.1. It sends to the peer that wrote last, or
/// to the one it is connected to. One thread at a time.
class LoopbackUdp {
 public:
  /// @throws base::ConfigError(failure) when no port can be opened
  explicit LoopbackUdp(const std::string& failure);

  int fd() const { return socket_.get(); }
  std::uint16_t port() const { return port_; }
  /// From now on sends to this port of 127.0.0.1 and receives from no other. @return false: refused
  bool connect(std::uint16_t port);
  /// A datagram is lost while no peer is known, or when it is not taken.
  void send(std::span<const std::uint8_t> bytes);
  /// One datagram, valid until the next read; empty: none is waiting.
  std::span<const std::uint8_t> read();

 private:
  base::Descriptor socket_;
  std::uint16_t port_ = 0;
  sockaddr_in peer_{};
  std::vector<std::uint8_t> buffer_;
};

}  // namespace cas::hils
