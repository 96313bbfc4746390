// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/earth/geodesy.hpp"
#include "libsim/api/world.hpp"
#include "libsim/core/body/shape.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/terrain/elevation_map.hpp"
#include "libsim/core/terrain/terrain_config.hpp"

namespace cas::sim {

/// Ground from elevation files, without end.
///
/// The surface in W is made of triangles over a grid of squares, as fine as the file that has home;
/// contacts and rays meet the same ones. Without data it is at mean sea level. Tiles of the grid
/// are made when they are asked for, and the newest stay in memory: 9 MB, however far a vehicle
/// flies.
class CAS_SIM_EXPORT Terrain {
 public:
  /// Squares along the edge of a patch of triangles.
  static constexpr std::int64_t kPatchCells = 8;

  /// @throws base::ConfigError when a file cannot be read, and when none has home
  Terrain(const TerrainConfig& config, const base::LocalProjection& projection);

  /// Above mean sea level, of the files; nullopt: they have no data there.
  std::optional<double> elevation_m(double lat_deg, double lon_deg) const;
  /// z of the surface in W, m.
  double height_m(double x_m, double y_m) const;
  /// Unit normal of the triangle at a place, pointing up.
  Eigen::Vector3d normal_W(double x_m, double y_m) const;
  /// A height that the surface over a square place does not exceed, by its steepest triangle; m.
  /// @param half_m  of its edge
  double highest_m(double x_m, double y_m, double half_m) const;
  /// The first triangle along a ray (unit direction), from above or below.
  std::optional<RayHit> cast(const Eigen::Vector3d& origin_W, const Eigen::Vector3d& direction_W,
                             double range_m) const;
  /// Makes the tile that a vehicle will be over in some seconds.
  void look_ahead(const Eigen::Vector3d& p_W, const Eigen::Vector3d& v_W) const;

  /// Length of a square's edge, m.
  double cell_m() const { return cell_m_; }
  /// The triangles of kPatchCells x kPatchCells squares, about the south-west corner of the first
  /// in its height: (i, j) patches east and north of the origin.
  TriangleMesh patch(std::int64_t i, std::int64_t j) const;

  /// The ground about home for a picture: its own triangles near by, larger ones farther away, up
  /// to 8 km. A corner without data is at mean sea level.
  TriangleMesh picture() const;

  /// One sentence about files, grid and geoid, for the log.
  std::string description() const;
  /// Tiles in memory.
  std::size_t tiles() const { return tiles_.size(); }

 private:
  static constexpr std::int64_t kCells = 32;  // of a tile, along an edge

  struct Tile {
    std::int64_t i = 0;  // tiles east and north of the origin
    std::int64_t j = 0;
    double highest_m = 0;
    std::vector<double> z_m;  // of (kCells + 1)^2 corners, row by row from the south-west
  };
  /// A place of the grid: its square, and where in the square it is, 0 to 1.
  struct Spot {
    std::int64_t i;
    std::int64_t j;
    double u;
    double v;
  };
  class RayWalk;

  Spot spot_of(double x_m, double y_m) const;
  const Tile& tile(std::int64_t i, std::int64_t j) const;
  Tile make_tile(std::int64_t i, std::int64_t j) const;
  double measured_m(std::int64_t i, std::int64_t j) const;
  double corner_m(std::int64_t i, std::int64_t j) const;

  base::LocalProjection projection_;
  ElevationMap map_;
  std::optional<ElevationMap> geoid_;
  double cell_m_ = 0;
  mutable std::list<Tile> tiles_;  // the newest first
  mutable std::unordered_map<std::uint64_t, std::list<Tile>::iterator> by_place_;
};

}  // namespace cas::sim
