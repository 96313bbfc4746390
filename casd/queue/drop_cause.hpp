// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "base/enum_words.hpp"

namespace cas::casd {

/// Why a packet did not go out.
enum class DropCause : std::uint8_t {
  kAge,         ///< would have arrived too late to be worth anything
  kBandwidth,   ///< too late as well, because of the cap that the topology sets
  kQueueFull,   ///< its class, or the socket, had no room left
  kClosed,      ///< the link was away, or came back and the packet was stale
  kStalled,     ///< the peer stopped reading and was closed
  kUnsignable,  ///< its checksum fits no message, so that it cannot be signed
  kSuperseded,  ///< a newer setpoint of its stream took its place
};
inline constexpr base::EnumWords<DropCause::kSuperseded> kDropCauseWords{
    "age", "bandwidth", "queue_full", "closed", "stalled", "unsignable", "superseded"};
inline constexpr int kDropCauses = kDropCauseWords.kCount;
constexpr std::string_view to_string(DropCause cause) { return kDropCauseWords[cause]; }

}  // namespace cas::casd
