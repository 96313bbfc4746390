// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string_view>

namespace cas::sim {

/// The terrain of the world by latitude and longitude. The host publishes it on topic `terrain`
/// once, before time zero; in a world without terrain never.
struct TerrainSource {
  static constexpr std::string_view kTypeName = "cas.TerrainSource";
  static constexpr unsigned kTypeVersion = 1;
  /// Height above mean sea level, m; 0 without data. @param degrees  latitude, longitude
  using Elevation = std::function<double(double, double)>;
  Elevation elevation_m;
};

}  // namespace cas::sim
