// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "mavlink_gen/runtime/packet.hpp"

namespace cas::mav::services {

/// EVENT of MAVLink's events interface, by which PX4 (v1.13 and later) gives most reasons not to
/// arm.
inline constexpr std::uint32_t kEventMessage = 410;

/// The id of an EVENT: an event's name by FNV-1a, 24 bits of it, behind the component that defines
/// it (1: PX4). A vehicle that sends the message has the texts in its component information; only
/// reasons that keep it from flying are known here.
/// @return nullopt for a packet that is no EVENT
std::optional<std::uint32_t> event_id(const PacketView& packet);
/// Whether PX4 begins its list of failed arming checks anew with this event.
bool begins_check_list(std::uint32_t id);
/// A failed arming check in words; empty for an event that is none of those known.
std::string_view failed_check(std::uint32_t id);

}  // namespace cas::mav::services
