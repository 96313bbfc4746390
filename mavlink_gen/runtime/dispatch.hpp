// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <type_traits>

#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/message.hpp"

namespace cas::mav {

/// Decodes `packet` as a Message and gives it to the visitor, if that takes such a message.
/// @return whether it does
template <class Message, class Visitor>
bool visit_as(const PacketView& packet, Visitor& visitor) {
  if constexpr (std::is_invocable_v<Visitor&, const Message&>) {
    visitor(decode_payload<Message>(packet.payload));
    return true;
  } else {
    return false;
  }
}

/// The fields of a packet's message without decoding it; nullopt when the packet holds another one.
/// The view borrows the packet's bytes.
template <class Message>
std::optional<typename Message::View> view_as(const PacketView& packet) {
  if (packet.message_id != Message::kId) return std::nullopt;
  return typename Message::View(packet.payload.data(), packet.payload.size());
}

/// A string as a template argument.
template <std::size_t n>
struct FixedString {
  constexpr FixedString(const char (&text)[n]) {  // implicit: MessageNamed<"HIL_SENSOR">
    for (std::size_t i = 0; i < n; ++i) characters[i] = text[i];
  }
  constexpr TextView view() const { return {characters, n - 1}; }

  char characters[n]{};
};

}  // namespace cas::mav
