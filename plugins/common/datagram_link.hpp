// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>

#include "base/config/config.hpp"
#include "plugins/common/inet_address.hpp"

namespace cas::sim {

/// A UDP socket for one address: datagrams from others are dropped.
class DatagramLink {
 public:
  /// @throws base::ConfigError through `node`
  DatagramLink(const base::ConfigNode& node, const InetAddress& remote);
  ~DatagramLink();
  DatagramLink(const DatagramLink&) = delete;
  DatagramLink& operator=(const DatagramLink&) = delete;

  /// Never blocks: drops the packet, and counts it, if the socket is full.
  void send(std::span<const std::uint8_t> packet);
  /// The next datagram that is there, in `buffer`, cut to its size.
  std::optional<std::span<const std::uint8_t>> receive(std::span<std::uint8_t> buffer);
  /// {"remote":"127.0.0.1:19410","sent":50,"not_taken":0}
  nlohmann::ordered_json figures() const;

 private:
  InetAddress remote_;
  int socket_ = -1;
  std::uint64_t sent_ = 0;
  std::uint64_t not_taken_ = 0;
};

}  // namespace cas::sim
