// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/time/clock.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/available_modes.hpp"
#include "mavlink/common/current_mode.hpp"
#include "mavlink/common/protocol_version.hpp"

namespace cas::fcu {

struct FcuCore;

// What a ground station asks for once.
void send_autopilot_version(FcuCore& core, base::RunTime now, int version);
void send_protocol_version(FcuCore& core, base::RunTime now, int version);
/// All modes, one message each.
void send_available_modes(FcuCore& core, base::RunTime now, int version);
void send_current_mode(FcuCore& core, base::RunTime now, int version);

}  // namespace cas::fcu
