// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "casd/station/services.hpp"
#include "casd/station/vehicle_state.hpp"

namespace cas::casd {

/// MAV_CMD_DO_REPOSITION to a place relative to home, in m; without a yaw the heading is kept.
VehicleCommand reposition_command(const HomeAmsl& home, double north_m, double east_m,
                                  double down_m, std::optional<double> yaw_deg);

}  // namespace cas::casd
