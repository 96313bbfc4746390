// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/lidar/lidar_pattern.hpp"

#include <array>
#include <cmath>
#include <string>

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

std::vector<LidarBeam> read_spinning(const std::filesystem::path& file) {
  const auto node = base::ConfigNode::load(file);
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

std::vector<LidarBeam> read_csv(const std::filesystem::path& file) {
  NumberCsv csv(file, "pattern of a lidar", kMostPatternBytes, kPatternHeader);
  std::vector<LidarBeam> beams;
  for (std::array<double, 3> row{}; csv.next(row);) {
    const auto& [share, azimuth_deg, elevation_deg] = row;
    const double before = beams.empty() ? 0 : beams.back().share;
    if (share < before || share >= 1) {
      csv.fail("a share is from that of the line before to below 1");
    }
    if (beams.size() == kMostBeams) csv.fail("has more than a million beams");
    beams.push_back(
        {.share = share, .direction_S = direction_of(azimuth_deg, elevation_deg), .ring = 0});
  }
  if (beams.empty()) csv.fail("has no beam");
  return beams;
}

}  // namespace

std::vector<LidarBeam> load_lidar_pattern(const std::filesystem::path& file) {
  if (file.extension() == ".csv") return read_csv(file);
  return read_spinning(file);
}

}  // namespace cas::sim
