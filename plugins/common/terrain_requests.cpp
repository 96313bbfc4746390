// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/terrain_requests.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/angles.hpp"
#include "base/earth/deg_e7.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;

constexpr base::Duration kBetweenGrids = std::chrono::milliseconds(20);
constexpr int kGridsEast = 8;
constexpr int kGridsNorth = 7;
constexpr int kSide = 4;  // heights along the edge of a grid
/// m: a degree of the equator, by which ArduPilot lays its blocks (Location::offset).
constexpr double kDegree_m = 111'318.845;

/// Heights of one grid, row by row from the south, each from the west.
mv::TerrainData grid_of(const mv::TerrainRequest& request, int bit,
                        const TerrainSource::Elevation& elevation_m) {
  mv::TerrainData grid;
  grid.lat = request.lat;
  grid.lon = request.lon;
  grid.grid_spacing = request.grid_spacing;
  grid.gridbit = static_cast<std::uint8_t>(bit);
  for (int i = 0; i < kSide * kSide; ++i) {
    const double north_m = (bit / kGridsEast * kSide + i / kSide) * request.grid_spacing;
    const double east_m = (bit % kGridsEast * kSide + i % kSide) * request.grid_spacing;
    const double south_deg = base::degrees_of_e7(request.lat);
    const double lat = south_deg + north_m / kDegree_m;
    const double scale = std::max(0.01, std::cos((south_deg + lat) / 2 * base::kRadPerDeg));
    const double lon = base::degrees_of_e7(request.lon) + east_m / (kDegree_m * scale);
    grid.data[static_cast<std::size_t>(i)] =
        static_cast<std::int16_t>(std::lround(elevation_m(lat, std::remainder(lon, 360))));
  }
  return grid;
}

}  // namespace

std::optional<mv::TerrainData> TerrainRequests::next(base::SimTime now,
                                                     const TerrainSource::Elevation& elevation_m) {
  if (!request_ || now < due_) return std::nullopt;
  const int bit = std::countr_zero(request_->mask);
  if (bit >= kGridsEast * kGridsNorth || request_->grid_spacing == 0) {
    request_.reset();
    return std::nullopt;
  }
  request_->mask &= request_->mask - 1;
  due_ = now + kBetweenGrids;
  return grid_of(*request_, bit, elevation_m);
}

}  // namespace cas::sim
