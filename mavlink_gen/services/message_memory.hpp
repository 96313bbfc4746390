// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/time.hpp"

namespace cas::mav::services {

/// The newest packet of each message that one vehicle has sent. Bounded: further messages are not
/// kept, so that a sender of invented ids costs little.
class MessageMemory {
 public:
  struct Kept {
    std::vector<std::uint8_t> payload;  ///< as on the wire: possibly truncated
    Time at{};
  };

  static constexpr std::size_t kMaxMessages = 256;

  void on_packet(const PacketView& packet, Time now) {
    auto found = kept_.find(packet.message_id);
    if (found == kept_.end()) {
      if (kept_.size() == kMaxMessages) return;
      found = kept_.try_emplace(packet.message_id).first;
    }
    found->second.payload.assign(packet.payload.begin(), packet.payload.end());
    found->second.at = now;
  }

  /// @return nullptr when none came
  const Kept* find(std::uint32_t message_id) const {
    const auto found = kept_.find(message_id);
    return found == kept_.end() ? nullptr : &found->second;
  }

 private:
  std::map<std::uint32_t, Kept> kept_;
};

}  // namespace cas::mav::services
