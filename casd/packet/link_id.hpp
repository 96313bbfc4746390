// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

namespace cas::casd {

/// Slot of a link in the router, 0..63. A link keeps its slot for life, also over a reload.
using LinkId = std::uint8_t;
/// A set of links, bit i for link i.
using LinkMask = std::uint64_t;

inline constexpr int kMaxLinks = 64;
/// casd's own station (commander): the last slot, never used by a real link.
inline constexpr LinkId kLocalLink = 63;
inline constexpr LinkId kNoLink = 255;

constexpr LinkMask bit(LinkId link) { return LinkMask{1} << link; }

enum class LinkType : std::uint8_t { kUdp, kUdpServer, kSerial, kTcp, kTcpServer, kTlog };
/// The word of a topology: "udp", "udp_server", ...
constexpr std::string_view to_string(LinkType type) {
  switch (type) {
    case LinkType::kUdp:
      return "udp";
    case LinkType::kUdpServer:
      return "udp_server";
    case LinkType::kSerial:
      return "serial";
    case LinkType::kTcp:
      return "tcp";
    case LinkType::kTcpServer:
      return "tcp_server";
    case LinkType::kTlog:
      return "tlog";
  }
  return "?";
}

}  // namespace cas::casd
