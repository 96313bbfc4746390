// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "libsim/core/body/world_model.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/sim_config.hpp"

namespace cas::sim {

/// Entry point of libcas_sim_sdf.so: fills `model` from the first world of the SDF file that
/// `config` names, as load_world() of world_loader.hpp says. libsdformat has a library of its own
/// because it compiles eighty regular expressions whenever a program starts, and most flights read
/// no SDF file.
/// @throws base::ConfigError
extern "C" CAS_SIM_EXPORT void cas_load_sdf_world(const WorldConfig& config, WorldModel& model);

/// Symbol of cas_load_sdf_world() in libcas_sim_sdf.so.
inline constexpr const char* kLoadSdfWorld = "cas_load_sdf_world";

}  // namespace cas::sim
