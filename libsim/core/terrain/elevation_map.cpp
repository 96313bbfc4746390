// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/terrain/elevation_map.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"

namespace cas::sim {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostKeptSamples = kMostBlockSamples;  // in memory
/// A place on the edge of a file is in it, whatever rounding says.
constexpr double kEdgeRounding = 1e-9;  // of a step

std::vector<fs::path> files_of(std::span<const fs::path> paths) {
  std::vector<fs::path> files;
  for (const fs::path& path : paths) {
    if (!fs::is_directory(path)) {
      files.push_back(path);
      continue;
    }
    const std::size_t before = files.size();
    for (const auto& entry : fs::directory_iterator(path)) {
      if (is_elevation_file(entry.path())) files.push_back(entry.path());
    }
    if (files.size() == before) {
      throw base::ConfigError(path.string() +
                              ": the folder holds no elevation file (.hgt, .tif, .tiff)");
    }
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace

ElevationMap::ElevationMap(std::span<const fs::path> paths) {
  for (const fs::path& file : files_of(paths)) files_.push_back(open_elevation_file(file));
  std::ranges::stable_sort(files_, {}, [](const auto& file) { return file->grid().step_lat_deg; });
}

std::optional<double> ElevationMap::height_m(double lat_deg, double lon_deg) const {
  const auto spot = spot_of(lat_deg, lon_deg);
  if (!spot) return std::nullopt;
  const int column = static_cast<int>(std::floor(spot->column));
  const int row = static_cast<int>(std::floor(spot->row));
  const double u = spot->column - column;
  const double v = spot->row - row;
  const double weights[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  double sum = 0;
  double weight = 0;
  double known = 0;  // sum of the corners with data
  int corners = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const double height = sample_near(*spot, column + corner % 2, row + corner / 2);
    if (std::isnan(height)) continue;
    sum += weights[corner] * height;
    weight += weights[corner];
    known += height;
    ++corners;
  }
  if (corners == 0) return std::nullopt;
  return sum + (1 - weight) * known / corners;
}

std::optional<double> ElevationMap::step_deg(double lat_deg, double lon_deg) const {
  const auto spot = spot_of(lat_deg, lon_deg);
  if (!spot) return std::nullopt;
  return files_[spot->file]->grid().step_lat_deg;
}

/// Spot in the finest file that has the place. The file of the place before is tried first, if no
/// file is finer.
std::optional<ElevationMap::Spot> ElevationMap::spot_of(double lat_deg, double lon_deg) const {
  if (files_.front()->grid().step_lat_deg == files_[last_file_]->grid().step_lat_deg) {
    if (const auto spot = spot_in(last_file_, lat_deg, lon_deg)) return spot;
  }
  for (std::size_t file = 0; file < files_.size(); ++file) {
    const auto spot = spot_in(file, lat_deg, lon_deg);
    if (!spot) continue;
    last_file_ = file;
    return spot;
  }
  return std::nullopt;
}

/// Half a step around the outer samples belongs to the file, too.
std::optional<ElevationMap::Spot> ElevationMap::spot_in(std::size_t file, double lat_deg,
                                                        double lon_deg) const {
  const ElevationGrid& grid = files_[file]->grid();
  constexpr double kEdge = 0.5 + kEdgeRounding;
  const double row = (grid.north_deg - lat_deg) / grid.step_lat_deg;
  if (row < -kEdge || row > grid.rows - 1 + kEdge) return std::nullopt;
  const double from = lon_deg - grid.west_deg;
  const double edge = kEdge * grid.step_lon_deg;
  const double column = (from - 360 * std::floor((from + edge) / 360)) / grid.step_lon_deg;
  if (column > grid.columns - 1 + kEdge) return std::nullopt;
  return Spot{.file = file, .column = column, .row = row};
}

/// A corner of the cell around a spot; beyond the file's edge it is the neighbour's nearest sample,
/// or without a neighbour the sample at the edge.
double ElevationMap::sample_near(const Spot& cell, int column, int row) const {
  const ElevationGrid& grid = files_[cell.file]->grid();
  const int c = std::clamp(column, 0, grid.columns - 1);
  const int r = std::clamp(row, 0, grid.rows - 1);
  if (c == column && r == row) return sample(cell.file, c, r);
  const double lat_deg = grid.north_deg - row * grid.step_lat_deg;
  const double lon_deg = grid.west_deg + column * grid.step_lon_deg;
  for (std::size_t file = 0; file < files_.size(); ++file) {
    if (file == cell.file) continue;
    const auto spot = spot_in(file, lat_deg, lon_deg);
    if (!spot) continue;
    const ElevationGrid& other = files_[file]->grid();
    return sample(file,
                  std::clamp(static_cast<int>(std::lround(spot->column)), 0, other.columns - 1),
                  std::clamp(static_cast<int>(std::lround(spot->row)), 0, other.rows - 1));
  }
  return sample(cell.file, c, r);
}

double ElevationMap::sample(std::size_t file, int column, int row) const {
  const ElevationGrid& grid = files_[file]->grid();
  const Block& from = block(file, column / grid.block_columns, row / grid.block_rows);
  const int at = row % grid.block_rows * grid.block_columns + column % grid.block_columns;
  return from.heights[static_cast<std::size_t>(at)];
}

const ElevationMap::Block& ElevationMap::block(std::size_t file, int column, int row) const {
  const BlockKey key = std::uint64_t{file} << 40U |
                       static_cast<std::uint64_t>(static_cast<unsigned>(row)) << 20U |
                       static_cast<unsigned>(column);
  if (!blocks_.empty() && blocks_.front().key == key) return blocks_.front();
  if (const auto known = by_key_.find(key); known != by_key_.end()) {
    blocks_.splice(blocks_.begin(), blocks_, known->second);
    return blocks_.front();
  }
  const ElevationGrid& grid = files_[file]->grid();
  const auto size = static_cast<std::size_t>(grid.block_columns * grid.block_rows);
  Block read{.key = key, .heights = std::vector<float>(size)};
  files_[file]->read_block(column, row, read.heights);
  blocks_.push_front(std::move(read));
  by_key_[key] = blocks_.begin();
  samples_ += size;
  while (samples_ > kMostKeptSamples && blocks_.size() > 1) {
    samples_ -= blocks_.back().heights.size();
    by_key_.erase(blocks_.back().key);
    blocks_.pop_back();
  }
  return blocks_.front();
}

}  // namespace cas::sim
