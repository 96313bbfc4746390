// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>

#include "libsim/api/world.hpp"
#include "libsim/core/body/world_model.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/model_loader.hpp"
#include "libsim/core/load/sim_config.hpp"

namespace cas::sim {

class SimWorld;

/// z of the uppermost surface that never moves at a place, m; nullopt: there is none.
std::optional<double> surface_at(const SimWorld& world, double x_m, double y_m);

/// Height at which a vehicle stands on the uppermost surface below or beside its middle, m: the
/// highest of 5 x 5 rays down over its base. 0 where there is none.
CAS_SIM_EXPORT double standing_height(const SimWorld& world, const VehicleModel& model,
                                      const StartPose& pose);

/// A vehicle at rest and level, its lowest point `pose.z_m` above z = 0; without that at z = 0.
CAS_SIM_EXPORT BodyState start_state(const VehicleModel& model, const StartPose& pose);

/// Refuses a vehicle that starts inside something: its centre of gravity is in it, or it still
/// touches it 5.1 cm higher. Vehicles are not compared with each other.
/// @param world_model  what `world` was made of
/// @throws base::ConfigError naming vehicle, place and obstacle, and the height to start from
CAS_SIM_EXPORT void require_free_start(const SimWorld& world, const WorldModel& world_model,
                                       const VehicleModel& model, const VehicleConfig& vehicle);

/// Refuses a vehicle that would fall for ever: in a world with gravity, none of 5 x 5 rays from the
/// base of the vehicle straight down meets anything.
/// @param file  of the world, for the error message
/// @throws base::ConfigError with world, vehicle, place and remedy
CAS_SIM_EXPORT void require_ground(const SimWorld& world, const WorldModel& world_model,
                                   const VehicleModel& model, const VehicleConfig& vehicle,
                                   const std::filesystem::path& file);

}  // namespace cas::sim
