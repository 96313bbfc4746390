// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "base/time/clock.hpp"
#include "fcu/core/outbox.hpp"

namespace cas::fcu {

struct FcuCore;

/// A message of the controller about itself, on its way out.
struct Report {
  const FcuCore& core;
  Outbox& outbox;
  base::RunTime now;
  int version = 2;  ///< of MAVLink

  template <class Message>
  void send(const Message& message) const {
    outbox.reply(message, version);
  }
};

/// One message that the controller can send about itself.
struct MessageSource {
  std::uint32_t id = 0;
  double rate_hz = 0;  ///< usual rate; 0: on request only
  /// Sends it now; nothing while its content is unknown.
  void (*send)(const Report& r) = nullptr;
};
std::span<const MessageSource> message_sources();

}  // namespace cas::fcu
