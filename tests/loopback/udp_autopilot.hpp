// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/remote_log.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/udp_peer.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {

/// An autopilot at a socket of its own: HEARTBEATs, and answers to commands.
struct UdpAutopilot {
  using CommandLong = mavlink::common::CommandLong;
  using MavAutopilot = mavlink::common::MavAutopilot;
  using MavCmd = mavlink::common::MavCmd;
  using MavModeFlag = mavlink::common::MavModeFlag;
  using MavResult = mavlink::common::MavResult;
  using RemoteLogBlockStatus = mav::services::RemoteLogBlockStatus;

  explicit UdpAutopilot(MavAutopilot autopilot) : kind(autopilot) {}

  UdpPeer socket;
  PacketStream heard;
  mav::Encoder encoder{{1, 1}};
  MavAutopilot kind;
  MavModeFlag base_mode = MavModeFlag::kCustomModeEnabled;
  int starts = 0;
  int stops = 0;
  int requests = 0;
  bool answers = true;
  MavResult result = MavResult::kAccepted;
  std::vector<CommandLong> commands;
  std::vector<std::uint16_t> acks;
  std::vector<RemoteLogBlockStatus> statuses;

  void beat() {
    mavlink::common::Heartbeat heartbeat{
        .type = mavlink::common::MavType::kQuadrotor, .autopilot = kind, .base_mode = base_mode};
    socket.send(encoder(heartbeat));
  }
  void pump() {
    socket.read(heard);
    for (; !heard.packets().empty(); heard.packets().pop_front()) {
      const mav::PacketView packet = heard.packets().front().view();
      if (const auto command = mav::decode<CommandLong>(packet)) answer(*command);
      if (const auto ack = mav::decode<mavlink::common::LoggingAck>(packet))
        acks.push_back(ack->sequence);
      if (const auto status = mav::decode<RemoteLogBlockStatus>(packet))
        statuses.push_back(*status);
    }
  }
  void answer(const CommandLong& command) {
    commands.push_back(command);
    if (command.command == MavCmd::kLoggingStart) ++starts;
    if (command.command == MavCmd::kLoggingStop) ++stops;
    if (command.command == MavCmd::kRequestMessage) ++requests;
    if (!answers) return;
    mavlink::common::CommandAck ack{.command = command.command,
                                    .result = result,
                                    .target_system = 254,
                                    .target_component = 190};
    socket.send(encoder(ack));
  }
  template <class Message = mavlink::common::LoggingData>
  void piece(std::uint16_t sequence, const std::string& bytes, std::uint8_t first = 0) {
    Message message;
    message.target_system = 254;
    message.target_component = 190;
    message.sequence = sequence;
    message.first_message_offset = first;
    message.length = static_cast<std::uint8_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), message.data.begin());
    socket.send(encoder(message));
  }
  void block(std::uint32_t number, std::uint8_t content) {
    mav::services::RemoteLogDataBlock message{
        .seqno = number, .target_system = 254, .target_component = 190};
    message.data.fill(content);
    socket.send(encoder(message));
  }
  bool was_told(std::uint32_t number, std::uint8_t status) const {
    return std::any_of(statuses.begin(), statuses.end(), [&](const RemoteLogBlockStatus& each) {
      return each.seqno == number && each.status == status;
    });
  }
};

/// Lets an autopilot speak until it holds.
inline bool speaks_until(
    UdpAutopilot& autopilot, const std::function<bool()>& condition,
    const std::function<void()>& also = [] {}) {
  return wait_until([&] {
    autopilot.beat();
    also();
    autopilot.pump();
    return condition();
  });
}

}  // namespace cas::test
