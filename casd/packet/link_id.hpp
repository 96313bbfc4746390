// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "base/enum_words.hpp"

namespace cas::casd {

/// Slot of a link in the router. A link keeps its slot for life, also over a reload.
using LinkId = std::uint8_t;

/// Links of one casd at a time.
inline constexpr int kMaxLinks = 250;
/// Slots: those of the links, and that of casd's own station.
inline constexpr int kLinkSlots = kMaxLinks + 1;
/// casd's own station (commander): the last slot of a LinkMask's first word, never that of a link.
inline constexpr LinkId kLocalLink = 63;
inline constexpr LinkId kNoLink = 255;

enum class LinkType : std::uint8_t { kUdp, kUdpServer, kSerial, kTcp, kTcpServer, kTlog };
/// The word of a topology: "udp", "udp_server", ...
constexpr std::string_view to_string(LinkType type) {
  constexpr base::EnumWords<LinkType::kTlog> kWords{"udp", "udp_server", "serial",
                                                    "tcp", "tcp_server", "tlog"};
  return kWords[type];
}

}  // namespace cas::casd
