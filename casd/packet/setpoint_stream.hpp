// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "casd/packet/packet_info.hpp"

namespace cas::casd {

/// Whether two setpoints are of one stream: the same message from the same sender over the same way
/// (or group of ways) for the same target.
bool same_stream(const PacketInfo& a, const PacketInfo& b);

/// Whether a setpoint covers an older one of its stream, so that the older one need not be sent.
/// Messages that may not cover an older one: RC_CHANNELS_OVERRIDE (ignored channels),
/// SET_ATTITUDE_TARGET and SET_POSITION_TARGET_* (fields that their type mask ignores; another
/// frame), MANUAL_CONTROL (other buttons), SET_ACTUATOR_CONTROL_TARGET (another group).
bool replaces(const PacketInfo& info, std::span<const std::uint8_t> newer,
              std::span<const std::uint8_t> older);

}  // namespace cas::casd
