// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "base/config/config.hpp"
#include "libsim/api/mavlink_message.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/message_table.hpp"
#include "plugins/common/datagram_sender.hpp"

namespace cas::sim {

/// Sends messages of plugins as UDP packets, as a companion computer does: to a link of casd, which
/// passes them to a link of the autopilot.
class CompanionSender {
 public:
  /// @param remote  the key with HOST:PORT
  /// @param self  system and component of the packets
  /// @throws base::ConfigError through `remote`
  CompanionSender(const base::ConfigNode& remote, mav::Source self);

  /// Never blocks: drops the packet, and counts it, if the socket is full.
  void send(const mav::MessageInfo& info, const MavlinkMessage& message);
  /// Those of its DatagramSender.
  nlohmann::ordered_json figures() const;

 private:
  DatagramSender datagrams_;
  mav::Source self_;
  std::uint8_t sequence_ = 0;
};

}  // namespace cas::sim
