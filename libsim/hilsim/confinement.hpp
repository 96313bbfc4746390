// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "libsim/core/run/sim_runner.hpp"

namespace cas::sim {

/// Where hilsim may read while it runs: system and shipped files, the folders of the plugins, of
/// the simulation file and of the vehicles' files, the visuals' meshes, and each file that a value
/// in these files names. Not in it: the user's other files, keys and tokens among them.
/// @param file         the simulation file
/// @param plugin_dirs  those of the command line
std::vector<std::filesystem::path> readable_places(
    const SimRunner& runner, const std::filesystem::path& file,
    const std::vector<std::filesystem::path>& plugin_dirs);

/// Where hilsim may write because a plugin external_ahrs or ubx has its serial line there: below
/// /dev for a device, which comes back as another file when it is plugged in again; what makes a
/// pseudo-terminal and the folder of its symlink else.
std::vector<std::filesystem::path> serial_places(const SimConfig& config);

}  // namespace cas::sim
