// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/companion_sender.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <span>

#include "plugins/common/plugin_messages.hpp"

namespace cas::sim {

CompanionSender::CompanionSender(const base::ConfigNode& remote, mav::Source self)
    : datagrams_(remote, InetAddress::parse(remote)), self_(self) {}

void CompanionSender::send(const mav::MessageInfo& info, const MavlinkMessage& message) {
  std::array<std::uint8_t, mav::kMaxPacketBytes> packet;
  const std::size_t size = encode_message(info, message, self_, sequence_++, packet);
  datagrams_.send(std::span(packet).first(size));
}

nlohmann::ordered_json CompanionSender::figures() const { return datagrams_.figures(); }

}  // namespace cas::sim
