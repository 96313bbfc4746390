// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "base/config/frame_table.hpp"
#include "base/config/vehicle.hpp"
#include "libsim/core/load/model_loader.hpp"

namespace cas::sim {

/// What a vehicle is made of, for `hilsim --describe`: mass, centre of gravity and inertia of the
/// model that flies, rotors, hover, thrust-to-weight ratio, scales, effectiveness matrix with its
/// rank, and the frame of `frames` that it is.
std::string describe_vehicle(const base::Vehicle& vehicle, const VehicleModel& model,
                             const std::vector<base::Frame>& frames);

/// The vehicle from above (nose up) and from its left side (nose to the left) as SVG: collision
/// shapes by their outlines, rotor discs with number and sense of turning, centre of gravity, and a
/// bar of 0.1 m.
std::string draw_vehicle(const base::Vehicle& vehicle, const VehicleModel& model);

}  // namespace cas::sim
