// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "hils/run/run_request.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::hils {

/// Disarms an autopilot on its serial line without casd, which has died: a forced disarm five times
/// a second for 3 s, until its HEARTBEAT says that it is disarmed.
/// @param line  which no other program has open
/// @return why it may still be armed, as a clause; nullopt: it is disarmed
std::optional<std::string> disarm_by_line(const FcuDevice& line, mav::Source vehicle);

}  // namespace cas::hils
