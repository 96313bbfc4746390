// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "libsim/core/body/world_model.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/sim_config.hpp"

namespace cas::sim {

/// The world that a configuration describes: gravity and ground, or an SDF file.
///
/// An SDF file's first world is read, through libsdformat: models with their poses and their box,
/// sphere, cylinder, plane, mesh (STL, OBJ, COLLADA) and heightmap (PNG) collisions with friction,
/// stiffness and damping, nested models, <include> by path and model://, gravity, wind, spherical
/// coordinates, physics step and real-time factor. Models do not move; `warnings` names unsupported
/// parts of the file and meshes that cannot be read, with file and line. A collision without
/// contacts (<collide_without_contact>, a <collide_bitmask> without a bit of a vehicle's) is no
/// obstacle here.
/// @throws base::ConfigError when there is no readable world, when a number is not read whole or
/// lies beyond what a body or a place can have, for a world that libsdformat would take more than 4
/// GB for, and when a model or mesh is not found and `missing` does not allow that
CAS_SIM_EXPORT WorldModel load_world(const WorldConfig& config);

/// The whole world of a simulation: with the air of its weather and its terrain.
/// @throws base::ConfigError as above, without any place of home, and for an elevation file that
/// cannot be read
CAS_SIM_EXPORT WorldModel load_world(const SimConfig& config);
/// Home of a simulation with that world. @throws base::ConfigError where neither names one
CAS_SIM_EXPORT base::Geodetic home_of(const SimConfig& config, const WorldModel& world);

/// load_world() of an SDF file.
CAS_SIM_EXPORT WorldModel load_sdf_world(const std::filesystem::path& file,
                                         const std::vector<std::filesystem::path>& model_path,
                                         Missing missing = Missing::kError);

}  // namespace cas::sim
