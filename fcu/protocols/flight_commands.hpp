// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/time/clock.hpp"
#include "fcu/flight/flight_mode.hpp"
#include "fcu/protocols/command.hpp"

namespace cas::fcu {

struct FcuCore;

/// Carries out a command about the flight: arming, modes, places, speeds, home, reboot.
/// @return UNSUPPORTED when it is not one of these
mavlink::common::MavResult flight_command(const Command& command, FcuCore& core, base::RunTime now);

/// Changes the mode on a request; nothing: UNSUPPORTED.
mavlink::common::MavResult set_flight_mode(std::optional<FlightMode> mode, FcuCore& core,
                                           base::RunTime now);

}  // namespace cas::fcu
