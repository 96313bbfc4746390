// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/measure/tracking.hpp"

namespace cas::hils {

/// True height of a vehicle over the terrain.
struct TerrainClearance {
  double least_m = 0;
  double most_m = 0;
};

/// Between the first and the last waypoint above terrain of each mission; nullopt when no two were
/// passed.
/// @param ground_m  height of the terrain in the axes of the truth, by north and east, m
std::optional<TerrainClearance> terrain_clearance(
    const std::vector<Stage>& stages, std::span<const PoseSample> truth,
    const std::function<double(double, double)>& ground_m);

/// The same over the terrain of the world that was flown in; nullopt where it has none, too.
std::optional<TerrainClearance> terrain_clearance(const std::vector<Stage>& stages,
                                                  std::span<const PoseSample> truth,
                                                  const std::filesystem::path& simulator_config);

}  // namespace cas::hils
