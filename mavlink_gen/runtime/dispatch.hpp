// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <type_traits>

#include "mavlink_gen/runtime/codec.hpp"

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

}  // namespace cas::mav
