// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/lidar/lidar_pattern.hpp"

#include <array>
#include <cmath>
#include <sstream>
#include <string>

#include "base/angles.hpp"
#include "base/byte_order_mark.hpp"
#include "base/config/config.hpp"
#include "base/config/config_whole.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"

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

/// Lines of numbers with commas between them.
class PatternCsv {
 public:
  explicit PatternCsv(const std::filesystem::path& file)
      : file_(file),
        stream_(base::read_foreign_file(file, "pattern of a lidar", kMostPatternBytes)) {}

  std::vector<LidarBeam> beams() {
    std::string text;
    if (!next(text) || text != kPatternHeader) {
      fail(std::string("the first line must be ") + kPatternHeader);
    }
    std::vector<LidarBeam> beams;
    while (next(text)) {
      if (text.empty()) continue;
      const auto [share, azimuth_deg, elevation_deg] = parse(text);
      const double before = beams.empty() ? 0 : beams.back().share;
      if (share < before || share >= 1) fail("a share is from that of the line before to below 1");
      if (beams.size() == kMostBeams) fail("has more than a million beams");
      beams.push_back(
          {.share = share, .direction_S = direction_of(azimuth_deg, elevation_deg), .ring = 0});
    }
    if (beams.empty()) fail("has no beam");
    return beams;
  }

 private:
  [[noreturn]] void fail(const std::string& sentence) const {
    throw base::ConfigError(file_.string() + ":" + std::to_string(line_) + ": " + sentence);
  }

  bool next(std::string& text) {
    if (!std::getline(stream_, text)) return false;
    ++line_;
    if (line_ == 1) text.erase(0, text.size() - base::without_byte_order_mark(text).size());
    if (!text.empty() && text.back() == '\r') text.pop_back();
    return true;
  }

  std::array<double, 3> parse(const std::string& text) const {
    std::istringstream words(text);
    std::array<double, 3> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool read = static_cast<bool>(words >> values[i]);
      if (!read || !std::isfinite(values[i])) fail("needs three numbers with commas between them");
      if (i + 1 < values.size() && words.get() != ',') fail("needs three numbers");
    }
    if (words.get() != std::istringstream::traits_type::eof()) fail("has more than three numbers");
    return values;
  }

  std::filesystem::path file_;
  std::istringstream stream_;
  int line_ = 0;
};

}  // namespace

std::vector<LidarBeam> load_lidar_pattern(const std::filesystem::path& file) {
  if (file.extension() == ".csv") return PatternCsv(file).beams();
  return read_spinning(file);
}

}  // namespace cas::sim
