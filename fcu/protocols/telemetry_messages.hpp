// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/time/clock.hpp"

namespace cas::fcu {

struct FcuCore;

/// One message that the controller can send about itself.
struct MessageSource {
  std::uint32_t id = 0;
  double rate_hz = 0;  ///< usual rate; 0: on request only
  void (*send)(FcuCore& core, base::RunTime now, int version) = nullptr;
};

std::span<const MessageSource> message_sources();

/// Sent at once when arming state, mode or landed state change.
inline constexpr std::array<std::uint32_t, 2> kHurriedIds{0, 245};

}  // namespace cas::fcu
