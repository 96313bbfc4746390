// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "tests/support/packet_stream.hpp"

namespace cas::test {

/// A UDP socket on a free port of 127.0.0.1 that plays simulator or ground station.
class UdpPeer {
 public:
  UdpPeer();
  ~UdpPeer();
  UdpPeer(const UdpPeer&) = delete;
  UdpPeer& operator=(const UdpPeer&) = delete;

  std::uint16_t port() const { return port_; }
  /// "127.0.0.1:PORT".
  std::string endpoint() const;
  /// Where packets go from now on.
  void set_remote(std::uint16_t port) { remote_ = port; }
  void send(std::span<const std::uint8_t> bytes);
  /// Where the newest datagram came from; 0 before the first.
  std::uint16_t newest_sender() const { return sender_; }
  /// Reads all waiting datagrams. @return datagrams read
  std::size_t read(PacketStream& into);

 private:
  int fd_ = -1;
  std::uint16_t port_ = 0;
  std::uint16_t remote_ = 0;
  std::uint16_t sender_ = 0;
};

/// Port of "127.0.0.1:14550".
std::uint16_t port_of(const std::string& endpoint);

}  // namespace cas::test
