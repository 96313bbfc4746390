// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "mavlink_gen/runtime/encode.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::mav {

/// Reads a payload: missing bytes are zero, extra bytes are ignored.
template <class Message>
Message decode_payload(std::span<const std::uint8_t> payload) {
  if (payload.size() >= Message::kMaxLength) return Message::unpack(payload.data());
  std::array<std::uint8_t, Message::kMaxLength> filled{};
  if (!payload.empty()) std::memcpy(filled.data(), payload.data(), payload.size());
  return Message::unpack(filled.data());
}

/// The message in a packet; nullopt when the packet holds another one. The parser has checked it.
template <class Message>
std::optional<Message> decode(const PacketView& packet) {
  if (packet.message_id != Message::kId || packet.payload.size() > kMaxPayloadBytes) {
    return std::nullopt;
  }
  return decode_payload<Message>(packet.payload);
}

}  // namespace cas::mav
