// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace cas::sim {

/// One beam of a scan. Axes S of the sensor: x forward, y left, z up.
struct LidarBeam {
  double share = 0;             ///< of the scan's duration at which it fires, 0 to below 1
  Eigen::Vector3d direction_S;  ///< unit
  std::uint16_t ring = 0;       ///< its laser; of a CSV file 0
};

/// Most beams of one scan.
inline constexpr std::size_t kMostBeams = 1'000'000;

/// The beams of one scan in the order in which they fire.
///
/// A YAML file has a spinning sensor: `columns` a turn, in each of them a beam for each of
/// `elevations_deg`, all at once; `azimuth_offsets_deg` turns a laser's beams against the column
/// (left is positive). It spins clockwise from x, as seen from above. A CSV file has any pattern:
/// `share,azimuth_deg,elevation_deg` of each beam, azimuth to the left, shares in order.
/// @throws base::ConfigError "FILE:LINE: sentence"
std::vector<LidarBeam> load_lidar_pattern(const std::filesystem::path& file);

}  // namespace cas::sim
