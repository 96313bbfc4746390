// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "libsim/api/beacon_source.hpp"
#include "libsim/core/body/world_model.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/sim_config.hpp"

namespace cas::sim {

class SimWorld;

/// Where a beacon is: at its place in W, or on its moving obstacle.
/// @param model  of which `world` was made; outlives the beacon
/// @throws base::ConfigError at its key `on` for an obstacle that the world does not have, and at
/// the beacon where it has no height and nothing is below it
CAS_SIM_EXPORT BeaconSource beacon_source(const BeaconConfig& beacon, const WorldModel& model,
                                          const SimWorld& world);

}  // namespace cas::sim
