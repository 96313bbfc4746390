// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "libsim/core/body/world_model.hpp"
#include "libsim/core/load/sdf_headers.hpp"

namespace cas::sim {

/// Takes what a <world> says of its surroundings: gravity, wind, physics step and real-time factor,
/// place on Earth, magnetic field and air. Step, factor, field and air that cannot be are left out
/// with a warning. @throws base::ConfigError for gravity, wind or a place that cannot be
void take_sdf_environment(const sdf::World& world, WorldModel& model);

}  // namespace cas::sim
