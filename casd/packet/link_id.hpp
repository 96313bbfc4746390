// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "base/enum_words.hpp"

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
  constexpr base::EnumWords<LinkType::kTlog> kWords{"udp", "udp_server", "serial",
                                                    "tcp", "tcp_server", "tlog"};
  return kWords[type];
}

}  // namespace cas::casd
