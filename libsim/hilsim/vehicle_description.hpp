// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "base/config/frame_table.hpp"
#include "base/config/vehicle.hpp"
#include "libsim/core/load/model_loader.hpp"

namespace cas::sim {

/// Whether a vehicle is to hover: not a plane whose rotors cannot carry it.
bool hovers(const base::Vehicle& vehicle);

/// Data sheet of a vehicle, for `hilsim --describe`: mass, centre of gravity and inertia as
/// simulated, rotors; of one that hovers thrust-to-weight ratio, scales, effectiveness matrix with
/// its rank, and the matching entry of `frames`; of one with wings what describe_wings() says.
std::string describe_vehicle(const base::Vehicle& vehicle, const VehicleModel& model,
                             const std::vector<base::Frame>& frames);

/// The vehicle from above (nose up) and from its left side (nose to the left) as SVG: collision
/// shapes by their outlines, rotor discs with number and sense of turning, centre of gravity, and a
/// bar of 0.1 m.
std::string draw_vehicle(const base::Vehicle& vehicle, const VehicleModel& model);

}  // namespace cas::sim
