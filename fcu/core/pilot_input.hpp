// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/time/clock.hpp"
#include "fcu/flight/flight_tasks.hpp"
#include "fcu/params/settings.hpp"

namespace cas::fcu {

/// Sources of sticks for the vehicle.
struct PilotInput {
  struct Heard {
    Sticks sticks;
    std::optional<base::RunTime> at;
  };
  Heard manual_control;  ///< MANUAL_CONTROL
  Heard radio;           ///< HIL_RC_INPUTS_RAW, RC_CHANNELS_OVERRIDE

  /// Sticks of the present pilot; nullopt if there is none.
  std::optional<Sticks> sticks(const FlightParams& params, base::RunTime now) const;
};

}  // namespace cas::fcu
