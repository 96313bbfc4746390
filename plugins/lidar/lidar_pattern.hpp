// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace cas::sim {

/// One beam of a scan. Axes S of the sensor: x forward, y left, z up.
struct LidarBeam {
  double share = 0;             ///< of the scan's duration at which it fires, 0 to below 1
  Eigen::Vector3d direction_S;  ///< unit
  std::uint16_t ring = 0;       ///< its laser, or row of a picture; of a CSV file 0
};

/// Most beams of one scan.
inline constexpr std::size_t kMostBeams = 1'000'000;

/// The picture of a depth camera: a beam through the middle of each pixel, row by row from the top
/// left. Pixels are square, the axis goes through the middle of the picture.
struct DepthPicture {
  int width = 0;
  int height = 0;
  double focal_px = 0;  ///< focal length in pixels

  /// Direction of a pixel's beam in S, with x = 1. @param column  from the left @param row  from
  /// the top
  Eigen::Vector3d ray_S(int column, int row) const;
  /// Number of the pixel that shows a place; nullopt: none. @param p_S  in S
  std::optional<std::size_t> pixel_of(const Eigen::Vector3d& p_S) const;
  std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

/// The beams of one scan in the order in which they fire.
struct LidarPattern {
  std::vector<LidarBeam> beams;
  std::optional<DepthPicture> picture;  ///< of a depth camera
};

/// Reads a pattern.
///
/// A YAML file with `columns` has a spinning sensor: `columns` a turn, in each of them a beam for
/// each of `elevations_deg`, all at once; `azimuth_offsets_deg` turns a laser's beams against the
/// column (left is positive). It spins clockwise from x, as seen from above. One with `width` has a
/// depth camera, whose pixels of `width` by `height` over `horizontal_fov_deg` all fire at once. A
/// CSV file has any pattern: `share,azimuth_deg,elevation_deg` of each beam, azimuth to the left,
/// shares in order.
/// @throws base::ConfigError "FILE:LINE: sentence"
LidarPattern load_lidar_pattern(const std::filesystem::path& file);

}  // namespace cas::sim
