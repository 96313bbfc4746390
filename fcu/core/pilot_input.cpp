// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/core/pilot_input.hpp"

namespace cas::fcu {

std::optional<Sticks> PilotInput::sticks(const FlightParams& params, base::RunTime now) const {
  // COM_RC_IN_MODE: 0 radio only, 1 MANUAL_CONTROL only, 2 and 3 either, 4 none.
  const int mode = params.manual_input;
  const auto fresh = [&](const Heard& heard) {
    return heard.at && base::to_seconds(now - *heard.at) < params.manual_timeout_s;
  };
  if (mode != 0 && mode != 4 && fresh(manual_control)) return manual_control.sticks;
  if (mode != 1 && mode != 4 && fresh(radio)) return radio.sticks;
  return std::nullopt;
}

}  // namespace cas::fcu
