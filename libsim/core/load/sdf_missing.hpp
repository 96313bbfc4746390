// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libsim/core/body/world_model.hpp"
#include "libsim/core/load/sim_config.hpp"

namespace cas::sim {

/// A model or mesh that is nowhere to be found.
struct MissingFile {
  std::string what;   ///< "model model://oak_tree"
  std::string place;  ///< FILE:LINE of the reference
  std::string uri;
  std::filesystem::path folder;  ///< of the file that names it
};

/// Refuses a world that names missing files, or warns of each, as `config` has it.
/// @param model_path  the folders searched
/// @throws base::ConfigError naming each reference and the places searched for the first, and for a
///     world that nothing is left of
void require_all(const std::vector<MissingFile>& missing, const WorldConfig& config,
                 const std::vector<std::filesystem::path>& model_path, WorldModel& model);

}  // namespace cas::sim
