// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "base/time/clock.hpp"
#include "fcu/core/home.hpp"
#include "fcu/estimation/estimator.hpp"
#include "fcu/flight/commander.hpp"
#include "fcu/flight/flight_status.hpp"
#include "fcu/flight/flight_tasks.hpp"
#include "fcu/params/params.hpp"
#include "fcu/params/settings.hpp"
#include "mavlink/common/enums.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::fcu {

/// A command from COMMAND_LONG or COMMAND_INT in one form. Latitude and longitude are in degrees.
struct Command {
  mavlink::common::MavCmd id{};
  std::array<double, 7> param{};
  mavlink::common::MavFrame frame = mavlink::common::MavFrame::kGlobal;
  mav::Source from;
  int version = 2;
};

/// Objects that commands act on. All outlive it.
struct CommandTarget {
  Commander& commander;
  const Estimator& estimator;
  Home& home;
  ParamStore& params;
  const FlightParams& flight;
  bool& reboot_wanted;
  std::function<TaskContext(base::RunTime now)> context;  ///< input of a flight mode
  std::function<ArmingInput(base::RunTime now)> arming_input;
  std::function<void()> reset_control;     ///< clears the integrators of the control loops
  std::function<void()> restart_estimate;  ///< restarts the estimator, as at start
};

/// A parameter that carries a whole number, within 0..`highest`; 0 for NaN and below.
inline std::uint32_t whole_number(double param, std::uint32_t highest) {
  if (!(param > 0)) return 0;
  return static_cast<std::uint32_t>(std::min(param, static_cast<double>(highest)));
}

/// Carries out a command about the flight: arming, modes, places, speeds, home, reboot.
/// @return UNSUPPORTED when it is not one of these
mavlink::common::MavResult flight_command(const Command& command, const CommandTarget& target,
                                          base::RunTime now);

/// Changes the mode on a request; nullopt: UNSUPPORTED.
mavlink::common::MavResult set_flight_mode(std::optional<FlightMode> mode,
                                           const CommandTarget& target, base::RunTime now);

}  // namespace cas::fcu
