// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "casd/station/services.hpp"
#include "casd/station/vehicle_state.hpp"

namespace cas::casd {

/// MAV_CMD_DO_REPOSITION to a place relative to home, in m; without a yaw the heading is kept.
VehicleCommand reposition_command(const HomeAmsl& home, double north_m, double east_m,
                                  double down_m, std::optional<double> yaw_deg);

/// The same place as the middle of a circle. PX4 takes MAV_CMD_DO_ORBIT: of a DO_REPOSITION it
/// leaves out the radius (v1.16.0).
/// @param radius_m  below 0 counter-clockwise
VehicleCommand circling(VehicleCommand reposition, Autopilot autopilot, double radius_m);

}  // namespace cas::casd
