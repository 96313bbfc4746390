// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "libsim/core/body/world_model.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/sim_config.hpp"

namespace cas::sim {

/// The world that a configuration describes: gravity and ground, or an SDF file.
/// @throws base::ConfigError
CAS_SIM_EXPORT WorldModel load_world(const WorldConfig& config);

/// Reads the first world of an SDF file through libsdformat: models with their poses and their
/// box, sphere, cylinder, plane and mesh (STL, OBJ) collisions with friction, nested models,
/// <include> by path and model://, gravity, wind, spherical coordinates, physics step and real-time
/// factor. All models stand still; each thing that is left out is named once in `warnings`.
/// @throws base::ConfigError when there is no readable world
CAS_SIM_EXPORT WorldModel load_sdf_world(const std::filesystem::path& file,
                                         const std::vector<std::filesystem::path>& model_path);

}  // namespace cas::sim
