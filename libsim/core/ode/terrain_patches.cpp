// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/terrain_patches.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cas::sim {

namespace {

constexpr std::size_t kMostTerrainPatches = 64;
constexpr double kStorey_m = 256;  // between two heights of an anchor

}  // namespace

TerrainPatches::TerrainPatches(std::shared_ptr<const Terrain> terrain, void* owner)
    : terrain_(std::move(terrain)), owner_(owner), space_(dSimpleSpaceCreate(nullptr)) {
  dSpaceSetCleanup(space_, 0);  // the patches own their geoms
}

TerrainPatches::~TerrainPatches() {
  for (const Patch& patch : patches_) destroy(patch);
  dSpaceDestroy(space_);
}

bool TerrainPatches::within(const Eigen::Vector3d& p_W, double radius) const {
  return p_W.z() - radius <= terrain_->highest_m(p_W.x(), p_W.y(), radius);
}

Eigen::Vector3d TerrainPatches::bring(const Eigen::Vector3d& p_W, double radius) {
  const double size = static_cast<double>(Terrain::kPatchCells) * terrain_->cell_m();
  const auto number = [](double place) { return static_cast<std::int64_t>(std::floor(place)); };
  const std::array<std::int64_t, 5> wanted{
      number((p_W.x() - radius) / size), number((p_W.y() - radius) / size),
      number((p_W.x() + radius) / size), number((p_W.y() + radius) / size),
      number(p_W.z() / kStorey_m)};
  if (wanted == brought_ && dSpaceGetNumGeoms(space_) > 0) return anchor_W_;
  while (dSpaceGetNumGeoms(space_) > 0) dSpaceRemove(space_, dSpaceGetGeom(space_, 0));
  const auto& [west, south, east, north, storey] = wanted;
  anchor_W_ = {static_cast<double>(west) * size, static_cast<double>(south) * size,
               static_cast<double>(storey) * kStorey_m};
  for (std::int64_t i = west; i <= east; ++i) {
    for (std::int64_t j = south; j <= north; ++j) {
      const dGeomID geom = patch(i, j).geom;
      const double ground_m =
          terrain_->height_m(static_cast<double>(i) * size, static_cast<double>(j) * size);
      dGeomSetPosition(geom, static_cast<double>(i - west) * size,
                       static_cast<double>(j - south) * size, ground_m - anchor_W_.z());
      dSpaceAdd(space_, geom);
    }
  }
  brought_ = wanted;
  return anchor_W_;
}

/// Makes it at first use; of many, the one that was not used for longest goes.
TerrainPatches::Patch& TerrainPatches::patch(std::int64_t i, std::int64_t j) {
  const auto known =
      std::ranges::find_if(patches_, [&](const Patch& p) { return p.i == i && p.j == j; });
  if (known != patches_.end()) {
    patches_.splice(patches_.begin(), patches_, known);
    return patches_.front();
  }
  // One that stands in the space was used last.
  if (patches_.size() > kMostTerrainPatches && dGeomGetSpace(patches_.back().geom) == nullptr) {
    destroy(patches_.back());
    patches_.pop_back();
  }
  Patch& made = patches_.emplace_front();
  made.i = i;
  made.j = j;
  made.mesh = std::make_shared<const TriangleMesh>(terrain_->patch(i, j));
  made.data = dGeomTriMeshDataCreate();
  dGeomTriMeshDataBuildDouble(
      made.data, made.mesh->vertices.data(), 3 * sizeof(double),
      static_cast<int>(made.mesh->vertices.size()), made.mesh->triangles.data(),
      static_cast<int>(3 * made.mesh->triangles.size()), 3 * sizeof(dTriIndex));
  made.geom = dCreateTriMesh(nullptr, made.data, nullptr, nullptr, nullptr);
  dGeomSetData(made.geom, owner_);
  return made;
}

void TerrainPatches::destroy(const Patch& patch) {
  dGeomDestroy(patch.geom);
  dGeomTriMeshDataDestroy(patch.data);
}

}  // namespace cas::sim
