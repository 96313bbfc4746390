// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

namespace cas::sim {

/// What a terrain is made of.
struct TerrainConfig {
  std::vector<std::filesystem::path> files;  ///< and folders of them
  /// Heights of the geoid over the ellipsoid; empty: elevations are above mean sea level already.
  std::filesystem::path geoid;
};

}  // namespace cas::sim
