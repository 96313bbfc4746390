// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "base/clock.hpp"
#include "casd/vehicle_state.hpp"

namespace cas::casd {

/// What speaks against flying, in words, as far as the vehicle says: sensors that it needs and does
/// not have or does not trust (SYS_STATUS), and the reasons that its own checks have told lately
/// ("Preflight Fail: ...", "PreArm: ..."). Empty when nothing does.
std::vector<std::string> complaints(const VehicleState& vehicle, base::RunTime now);

}  // namespace cas::casd
