// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mavlink_gen/runtime/packet.hpp"

namespace cas::mav::services {

/// The message, for this addressee.
template <class Message>
Message addressed(Message message, Source to) {
  message.target_system = to.system;
  message.target_component = to.component;
  return message;
}

/// Whether a message is for `self` or a broadcast; older autopilots set no target.
template <class Message>
bool is_for(const Message& message, Source self) {
  if (message.target_system == 0) return true;
  return message.target_system == self.system &&
         (message.target_component == 0 || message.target_component == self.component);
}

}  // namespace cas::mav::services
