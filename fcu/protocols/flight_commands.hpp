// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "base/time/clock.hpp"
#include "fcu/flight/flight_status.hpp"
#include "mavlink/common/enums.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::fcu {

struct FcuCore;

/// A command from COMMAND_LONG or COMMAND_INT in one form. Latitude and longitude are in degrees.
struct Command {
  mavlink::common::MavCmd id{};
  std::array<double, 7> param{};
  mavlink::common::MavFrame frame = mavlink::common::MavFrame::kGlobal;
  mav::Source from;
  int version = 2;
};

/// A parameter that carries a whole number, within 0..`highest`; 0 for NaN and below.
inline std::uint32_t whole_number(double param, std::uint32_t highest) {
  if (!(param > 0)) return 0;
  return static_cast<std::uint32_t>(std::min(param, static_cast<double>(highest)));
}

/// Carries out a command about the flight: arming, modes, places, speeds, home, reboot.
/// @return UNSUPPORTED when it is not one of these
mavlink::common::MavResult flight_command(const Command& command, FcuCore& core, base::RunTime now);

/// Changes the mode on a request; nothing: UNSUPPORTED.
mavlink::common::MavResult set_flight_mode(std::optional<FlightMode> mode, FcuCore& core,
                                           base::RunTime now);

}  // namespace cas::fcu
