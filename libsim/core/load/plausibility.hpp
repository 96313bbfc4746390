// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/config/vehicle.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/model_loader.hpp"

namespace cas::sim {

/// Figures of a vehicle that hardly go together, a sentence each with the unit that they may be in:
/// its size and its mass, its inertia, thrust to weight, balance in hover, speed of the rotors'
/// tips, and their lag.
/// The bounds are wide: each lies well outside anything that flies by rotors, from 20 g to 200 kg.
CAS_SIM_EXPORT std::vector<std::string> implausible(const base::Vehicle& vehicle,
                                                    const VehicleModel& model);

/// A sentence for gravity that is hardly in m/s^2, or does not point down.
CAS_SIM_EXPORT std::optional<std::string> implausible_gravity(const Eigen::Vector3d& gravity_W);

}  // namespace cas::sim
