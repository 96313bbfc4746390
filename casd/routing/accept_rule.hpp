// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// What a link takes in at all (`accept` of a link), before any route is asked. Nothing by default
/// is left out.
struct AcceptRule {
  bool read_only = false;               ///< takes in nothing: its peers may only listen
  std::vector<std::uint32_t> messages;  ///< only these; empty: all
  std::vector<std::uint8_t> systems;    ///< only of these senders; empty: all

  bool accepts(const mav::PacketView& packet) const {
    if (read_only) return false;
    const auto holds = [](const auto& list, auto value) {
      return list.empty() || std::find(list.begin(), list.end(), value) != list.end();
    };
    return holds(messages, packet.message_id) && holds(systems, packet.source.system);
  }

  friend bool operator==(const AcceptRule&, const AcceptRule&) = default;
};

}  // namespace cas::casd
