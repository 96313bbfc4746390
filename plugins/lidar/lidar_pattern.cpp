// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/lidar/lidar_pattern.hpp"

#include <array>
#include <cmath>

#include "base/angles.hpp"
#include "base/config/config.hpp"
#include "base/config/config_whole.hpp"
#include "plugins/common/number_csv.hpp"

namespace cas::sim {
namespace {

constexpr std::size_t kMostPatternBytes = std::size_t{64} << 20U;
constexpr const char* kPatternHeader = "share,azimuth_deg,elevation_deg";

/// @param azimuth_deg  to the left of x
Eigen::Vector3d direction_of(double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * base::kRadPerDeg;
  const double elevation = elevation_deg * base::kRadPerDeg;
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

std::vector<double> read_elevations(const base::ConfigNode& node) {
  auto elevations = node.as<std::vector<double>>();
  if (elevations.empty()) node.fail("names no beam");
  for (const double elevation : elevations) {
    if (!(std::abs(elevation) <= 90)) node.fail("are from -90 to 90");
  }
  return elevations;
}

std::vector<LidarBeam> read_spinning(const base::ConfigNode& node) {
  constexpr int kMostColumns = 36'000;
  const auto columns = base::get_whole_in<int>(node, "columns", 0, 1, kMostColumns);
  if (columns == 0) node.at("columns");  // says that it is missing
  const std::vector<double> elevations = read_elevations(node.at("elevations_deg"));
  std::vector<double> offsets(elevations.size(), 0.0);
  if (const auto key = node.find("azimuth_offsets_deg")) {
    offsets = key->as<std::vector<double>>();
    if (offsets.size() != elevations.size()) key->fail("has one number for each elevation");
  }
  node.reject_unused();
  if (static_cast<std::size_t>(columns) * elevations.size() > kMostBeams) {
    node.fail("has more than a million beams a turn");
  }
  std::vector<LidarBeam> beams;
  for (int column = 0; column < columns; ++column) {
    const double share = static_cast<double>(column) / columns;
    for (std::size_t ring = 0; ring < elevations.size(); ++ring) {
      beams.push_back({.share = share,
                       .direction_S = direction_of(offsets[ring] - 360 * share, elevations[ring]),
                       .ring = static_cast<std::uint16_t>(ring)});
    }
  }
  return beams;
}

LidarPattern read_depth_camera(const base::ConfigNode& node) {
  constexpr int kMostPixels = 10'000;  // along an edge
  DepthPicture picture;
  picture.width = base::get_whole_in<int>(node, "width", 0, 1, kMostPixels);
  picture.height = base::get_whole_in<int>(node, "height", 0, 1, kMostPixels);
  if (picture.height == 0) node.at("height");  // says that it is missing
  const double view_rad = node.require_in("horizontal_fov_deg", 1, 170) * base::kRadPerDeg;
  node.reject_unused();
  if (picture.pixels() > kMostBeams) node.fail("has more than a million pixels");
  picture.focal_px = picture.width / 2.0 / std::tan(view_rad / 2);
  LidarPattern pattern{.beams = {}, .picture = picture};
  for (int row = 0; row < picture.height; ++row) {
    for (int column = 0; column < picture.width; ++column) {
      pattern.beams.push_back({.share = 0,
                               .direction_S = picture.ray_S(column, row).normalized(),
                               .ring = static_cast<std::uint16_t>(row)});
    }
  }
  return pattern;
}

std::vector<LidarBeam> read_csv(const std::filesystem::path& file) {
  NumberCsv csv(file, "pattern of a lidar", kMostPatternBytes, kPatternHeader);
  std::vector<LidarBeam> beams;
  for (std::array<double, 3> row{}; csv.next(row);) {
    const auto& [share, azimuth_deg, elevation_deg] = row;
    const double before = beams.empty() ? 0 : beams.back().share;
    if (share < before || share >= 1) {
      csv.fail("a share is from that of the line before to below 1");
    }
    if (std::abs(azimuth_deg) > 360) csv.fail("an azimuth is from -360 to 360 degrees");
    if (std::abs(elevation_deg) > 90) csv.fail("an elevation is from -90 to 90 degrees");
    if (beams.size() == kMostBeams) csv.fail("has more than a million beams");
    beams.push_back(
        {.share = share, .direction_S = direction_of(azimuth_deg, elevation_deg), .ring = 0});
  }
  if (beams.empty()) csv.fail("has no beam");
  return beams;
}

}  // namespace

Eigen::Vector3d DepthPicture::ray_S(int column, int row) const {
  return {1, ((width - 1) / 2.0 - column) / focal_px, ((height - 1) / 2.0 - row) / focal_px};
}

std::optional<std::size_t> DepthPicture::pixel_of(const Eigen::Vector3d& p_S) const {
  if (!(p_S.x() > 0)) return std::nullopt;
  const double column = std::round((width - 1) / 2.0 - focal_px * p_S.y() / p_S.x());
  const double row = std::round((height - 1) / 2.0 - focal_px * p_S.z() / p_S.x());
  if (column < 0 || column >= width || row < 0 || row >= height) return std::nullopt;
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(column);
}

LidarPattern load_lidar_pattern(const std::filesystem::path& file) {
  if (file.extension() == ".csv") return {.beams = read_csv(file), .picture = {}};
  const auto node = base::ConfigNode::load(file);
  if (node.has("width")) return read_depth_camera(node);
  return {.beams = read_spinning(node), .picture = {}};
}

}  // namespace cas::sim
