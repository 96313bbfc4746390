// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/terrain/terrain.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/angles.hpp"
#include "base/earth/frames.hpp"
#include "base/error.hpp"

namespace cas::sim {

namespace {

constexpr std::size_t kMostTiles = 1024;
constexpr double kFinest_m = 0.25;
constexpr double kLookAhead_s = 5;
/// Length of a degree of a meridian on the projection's sphere, m.
constexpr double kDegree_m = 6'371'000.0 * base::kRadPerDeg;

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  return a >= 0 ? a / b : -((b - 1 - a) / b);
}

std::uint64_t key_of(std::int64_t i, std::int64_t j) {
  return static_cast<std::uint64_t>(i) << 32U | static_cast<std::uint32_t>(j);
}

/// Adds the two triangles of each square between corners that lie row by row from the south-west.
/// @param corners  in a row, and rows
void add_squares(TriangleMesh& mesh, std::uint32_t corners) {
  for (std::uint32_t b = 0; b + 1 < corners; ++b) {
    for (std::uint32_t a = 0; a + 1 < corners; ++a) {
      const std::uint32_t sw = b * corners + a;
      mesh.triangles.push_back({sw, sw + 1, sw + corners + 1});
      mesh.triangles.push_back({sw, sw + corners + 1, sw + corners});
    }
  }
}

std::int64_t cell_of(double place, double size) {
  return static_cast<std::int64_t>(std::floor(place / size));
}

/// Calls visit(i, j, from, to) for each square that a ray crosses, in order, until it says that it
/// has found something.
/// @param size  of the squares, m
/// @param from, to  stretch of the ray, m
/// @return whether it has
template <class Visit>
bool walk(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double size, double from,
          double to, Visit&& visit) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double next[2];
  double stride[2];
  for (const int axis : {0, 1}) {
    const double slope = direction[axis];
    const double cell = std::floor((origin[axis] + slope * from) / size);
    const double edge = (slope > 0 ? cell + 1 : cell) * size;
    next[axis] = slope == 0 ? kInfinity : std::max(from, (edge - origin[axis]) / slope);
    stride[axis] = slope == 0 ? kInfinity : size / std::abs(slope);
  }
  while (true) {
    const double end = std::min({next[0], next[1], to});
    const Eigen::Vector3d middle = origin + direction * ((from + end) / 2);
    if (visit(cell_of(middle.x(), size), cell_of(middle.y(), size), from, end)) return true;
    if (end >= to) return false;
    for (const int axis : {0, 1}) {
      if (next[axis] <= end) next[axis] += stride[axis];
    }
    from = end;
  }
}

}  // namespace

Terrain::Terrain(const TerrainConfig& config, const base::LocalProjection& projection)
    : projection_(projection), map_(config.files) {
  if (!config.geoid.empty()) geoid_.emplace(std::span(&config.geoid, 1));
  const base::Geodetic& home = projection.home();
  const auto step = map_.step_deg(home.lat_deg, home.lon_deg);
  if (!step) {
    throw base::ConfigError(fmt::format("terrain: no elevation file has home ({:.6f}, {:.6f})",
                                        home.lat_deg, home.lon_deg));
  }
  cell_m_ = std::max(kFinest_m, *step * kDegree_m);
}

std::optional<double> Terrain::elevation_m(double lat_deg, double lon_deg) const {
  const auto height = map_.height_m(lat_deg, lon_deg);
  if (!height || !geoid_) return height;
  return *height - geoid_->height_m(lat_deg, lon_deg).value_or(0);
}

Terrain::Spot Terrain::spot_of(double x_m, double y_m) const {
  const double x = x_m / cell_m_;
  const double y = y_m / cell_m_;
  const double i = std::floor(x);
  const double j = std::floor(y);
  return {static_cast<std::int64_t>(i), static_cast<std::int64_t>(j), x - i, y - j};
}

double Terrain::height_m(double x_m, double y_m) const {
  const auto [i, j, u, v] = spot_of(x_m, y_m);
  const double sw = corner_m(i, j);
  const double ne = corner_m(i + 1, j + 1);
  if (u >= v) {
    const double se = corner_m(i + 1, j);
    return sw + (se - sw) * u + (ne - se) * v;
  }
  const double nw = corner_m(i, j + 1);
  return sw + (ne - nw) * u + (nw - sw) * v;
}

Eigen::Vector3d Terrain::normal_W(double x_m, double y_m) const {
  const auto [i, j, u, v] = spot_of(x_m, y_m);
  const double sw = corner_m(i, j);
  const double ne = corner_m(i + 1, j + 1);
  const double third = u >= v ? corner_m(i + 1, j) : corner_m(i, j + 1);
  const Eigen::Vector3d lower(sw - third, third - ne, cell_m_);
  const Eigen::Vector3d upper(third - ne, sw - third, cell_m_);
  return (u >= v ? lower : upper).normalized();
}

double Terrain::highest_m(double x_m, double y_m, double half_m) const {
  double steepest2 = 0;  // squared, in heights of a square's edge
  const Spot low = spot_of(x_m - half_m, y_m - half_m);
  const Spot high = spot_of(x_m + half_m, y_m + half_m);
  for (std::int64_t j = low.j; j <= high.j; ++j) {
    for (std::int64_t i = low.i; i <= high.i; ++i) {
      const double sw = corner_m(i, j);
      const double se = corner_m(i + 1, j);
      const double nw = corner_m(i, j + 1);
      const double ne = corner_m(i + 1, j + 1);
      const double lower2 = (se - sw) * (se - sw) + (ne - se) * (ne - se);
      const double upper2 = (ne - nw) * (ne - nw) + (nw - sw) * (nw - sw);
      steepest2 = std::max({steepest2, lower2, upper2});
    }
  }
  return height_m(x_m, y_m) + half_m * std::sqrt(2 * steepest2) / cell_m_;
}

/// A ray on its way over the squares: on which side of the surface it began.
class Terrain::RayWalk {
 public:
  RayWalk(const Terrain& terrain, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)
      : terrain_(terrain), o_(origin), d_(direction) {
    begins_above_ = o_.z() >= terrain.height_m(o_.x(), o_.y());
  }

  bool cross_tile(const Tile& tile, double from, double to) {
    const double lowest = o_.z() + d_.z() * (d_.z() < 0 ? to : from);
    if (begins_above_ && lowest > tile.highest_m) return false;
    return walk(o_, d_, terrain_.cell_m_, from, to,
                [this](std::int64_t i, std::int64_t j, double begin, double end) {
                  return cross_cell(i, j, begin, end);
                });
  }

  const RayHit& hit() const { return hit_; }

 private:
  /// The ray's height over a triangle changes evenly along it: it passes where the sign changes.
  bool cross_cell(std::int64_t i, std::int64_t j, double from, double to) {
    const double size = terrain_.cell_m_;
    const double sw = terrain_.corner_m(i, j);
    const double se = terrain_.corner_m(i + 1, j);
    const double nw = terrain_.corner_m(i, j + 1);
    const double ne = terrain_.corner_m(i + 1, j + 1);
    const double u = o_.x() / size - static_cast<double>(i);
    const double v = o_.y() / size - static_cast<double>(j);
    // Where the ray goes from one triangle of the square to the other.
    const double across = (d_.x() - d_.y()) / size;
    double diagonal = across == 0 ? from : (v - u) / across;
    if (!(diagonal > from && diagonal < to)) diagonal = from;
    const auto cross_triangle = [&](double begin, double end) {
      const double middle = (begin + end) / 2;
      const bool lower = u + d_.x() / size * middle >= v + d_.y() / size * middle;
      const double slope_x = (lower ? se - sw : ne - nw) / size;
      const double slope_y = (lower ? ne - se : nw - sw) / size;
      const auto above = [&](double t) {
        return o_.z() + d_.z() * t - sw - slope_x * (u * size + d_.x() * t) -
               slope_y * (v * size + d_.y() * t);
      };
      return cross(above(begin), above(end), begin, end, {-slope_x, -slope_y, 1});
    };
    return (diagonal > from && cross_triangle(from, diagonal)) || cross_triangle(diagonal, to);
  }

  bool cross(double above_begin, double above_end, double begin, double end,
             const Eigen::Vector3d& normal) {
    if ((above_end >= 0) == begins_above_) return false;
    const bool is_within = (above_begin >= 0) == begins_above_;
    const double share = is_within ? above_begin / (above_begin - above_end) : 0;
    hit_.distance_m = begin + share * (end - begin);
    hit_.normal = normal.normalized() * (begins_above_ ? 1 : -1);
    return true;
  }

  const Terrain& terrain_;
  const Eigen::Vector3d& o_;
  const Eigen::Vector3d& d_;
  bool begins_above_;
  RayHit hit_;
};

std::optional<RayHit> Terrain::cast(const Eigen::Vector3d& origin_W,
                                    const Eigen::Vector3d& direction_W, double range_m) const {
  RayWalk ray(*this, origin_W, direction_W);
  const bool met = walk(origin_W, direction_W, cell_m_ * kCells, 0, range_m,
                        [&](std::int64_t i, std::int64_t j, double from, double to) {
                          return ray.cross_tile(tile(i, j), from, to);
                        });
  return met ? std::optional(ray.hit()) : std::nullopt;
}

void Terrain::look_ahead(const Eigen::Vector3d& p_W, const Eigen::Vector3d& v_W) const {
  const Eigen::Vector3d then_W = p_W + kLookAhead_s * v_W;
  const double size = cell_m_ * kCells;
  tile(cell_of(then_W.x(), size), cell_of(then_W.y(), size));
}

TriangleMesh Terrain::patch(std::int64_t i, std::int64_t j) const {
  TriangleMesh mesh;
  const double first_m = corner_m(i * kPatchCells, j * kPatchCells);
  for (std::int64_t b = 0; b <= kPatchCells; ++b) {
    for (std::int64_t a = 0; a <= kPatchCells; ++a) {
      mesh.vertices.emplace_back(static_cast<double>(a) * cell_m_, static_cast<double>(b) * cell_m_,
                                 corner_m(i * kPatchCells + a, j * kPatchCells + b) - first_m);
    }
  }
  add_squares(mesh, kPatchCells + 1);
  return mesh;
}

TriangleMesh Terrain::picture() const {
  constexpr double kFarthest_m = 8000;
  constexpr std::int64_t kAsFine = 24;  // squares from home to the first larger one
  constexpr std::int64_t kGrowth = 8;   // from there an edge is so small a part of its distance
  std::vector<std::int64_t> lines{0};   // of the grid, outwards from home
  while (static_cast<double>(lines.back()) * cell_m_ < kFarthest_m) {
    const std::int64_t edge = lines.back() < kAsFine ? 1 : lines.back() / kGrowth;
    lines.push_back(lines.back() + edge);
  }
  const std::size_t outwards = lines.size() - 1;
  for (std::size_t k = 1; k <= outwards; ++k) lines.insert(lines.begin(), -lines[2 * k - 1]);
  TriangleMesh mesh;
  for (const std::int64_t j : lines) {
    for (const std::int64_t i : lines) {
      mesh.vertices.emplace_back(static_cast<double>(i) * cell_m_, static_cast<double>(j) * cell_m_,
                                 measured_m(i, j));
    }
  }
  add_squares(mesh, static_cast<std::uint32_t>(lines.size()));
  return mesh;
}

const Terrain::Tile& Terrain::tile(std::int64_t i, std::int64_t j) const {
  if (!tiles_.empty() && tiles_.front().i == i && tiles_.front().j == j) return tiles_.front();
  const std::uint64_t key = key_of(i, j);
  if (const auto known = by_place_.find(key); known != by_place_.end()) {
    tiles_.splice(tiles_.begin(), tiles_, known->second);
    return tiles_.front();
  }
  tiles_.push_front(make_tile(i, j));
  by_place_[key] = tiles_.begin();
  if (tiles_.size() > kMostTiles) {
    by_place_.erase(key_of(tiles_.back().i, tiles_.back().j));
    tiles_.pop_back();
  }
  return tiles_.front();
}

Terrain::Tile Terrain::make_tile(std::int64_t i, std::int64_t j) const {
  Tile tile{.i = i, .j = j, .highest_m = -std::numeric_limits<double>::infinity(), .z_m = {}};
  tile.z_m.reserve((kCells + 1) * (kCells + 1));
  for (std::int64_t b = j * kCells; b <= (j + 1) * kCells; ++b) {
    for (std::int64_t a = i * kCells; a <= (i + 1) * kCells; ++a) {
      const double z = measured_m(a, b);
      tile.z_m.push_back(z);
      tile.highest_m = std::max(tile.highest_m, z);
    }
  }
  return tile;
}

/// Height of a corner of the grid, m in W.
double Terrain::measured_m(std::int64_t i, std::int64_t j) const {
  const Eigen::Vector3d p_W(static_cast<double>(i) * cell_m_, static_cast<double>(j) * cell_m_, 0);
  const base::Geodetic place = projection_.to_geodetic(base::swap_WN(p_W));
  return elevation_m(place.lat_deg, place.lon_deg).value_or(0) - projection_.home().alt_m;
}

double Terrain::corner_m(std::int64_t i, std::int64_t j) const {
  const std::int64_t a = floor_div(i, kCells);
  const std::int64_t b = floor_div(j, kCells);
  return tile(a, b).z_m[static_cast<std::size_t>((j - b * kCells) * (kCells + 1) + i - a * kCells)];
}

std::string Terrain::description() const {
  return fmt::format("terrain: {} elevation file{}, ground of {:.3g} m squares{}", map_.files(),
                     map_.files() == 1 ? "" : "s", cell_m_,
                     geoid_ ? "; elevations are over the ellipsoid, and over the geoid by its file"
                            : "; no geoid file, so elevations count as above mean sea level");
}

}  // namespace cas::sim
