// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/station/vehicle_state.hpp"

namespace cas::casd {

/// What speaks against flying, in words, as far as the vehicle says: sensors that it needs and does
/// not have or does not trust (SYS_STATUS), and the reasons that its own checks have told lately
/// ("Preflight Fail: ...", "PreArm: ..."). A vehicle that is armed has got over its reasons not to.
/// Empty when nothing speaks against it.
/// @param texts_before  status texts that do not count: so many had come when something was asked
std::vector<std::string> complaints(const VehicleState& vehicle, base::RunTime now,
                                    std::uint64_t texts_before = 0);

}  // namespace cas::casd
