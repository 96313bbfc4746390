// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/packet/packet_info.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd::test {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// A moment so long after the clock's start.
constexpr base::RunTime at(base::Duration since_start) {
  return base::RunTime(std::chrono::hours(1) + since_start);
}

/// A message as a whole packet.
template <class Message>
mav::PacketBuffer packet(const Message& message, mav::Source source, std::uint8_t sequence = 0) {
  mav::PacketBuffer buffer;
  buffer.size = mav::encode(message, source, sequence, buffer.bytes);
  return buffer;
}

inline mav::PacketView view(const mav::PacketBuffer& buffer) {
  return mav::view_packet(buffer.view());
}

/// A COMMAND_LONG for a target.
inline mavlink::common::CommandLong command_to(std::uint8_t system, std::uint8_t component) {
  mavlink::common::CommandLong message{.target_system = system,
                                       .target_component = component,
                                       .command = mavlink::common::MavCmd::kComponentArmDisarm};
  return message;
}

/// So many bytes of a class of traffic, read at a moment.
inline PacketInfo info(TrafficClass traffic, base::RunTime received, std::uint32_t message_id = 0) {
  PacketInfo result;
  result.traffic = traffic;
  result.received = received;
  result.message_id = message_id;
  return result;
}

inline std::vector<std::uint8_t> bytes(std::size_t size, std::uint8_t value = 0) {
  return std::vector<std::uint8_t>(size, value);
}

}  // namespace cas::casd::test
