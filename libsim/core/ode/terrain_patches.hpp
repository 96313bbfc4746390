// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ode/ode.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <list>
#include <memory>

#include "libsim/core/terrain/terrain.hpp"

namespace cas::sim {

/// The triangles of a terrain around one body at a time, as ODE's meshes.
///
/// ODE looks for triangles in single precision, which is a centimetre at 100 km. So the meshes lie
/// about an anchor beside the body, and who collides with them is moved there and back.
class TerrainPatches {
 public:
  /// @param owner  data of the geoms
  TerrainPatches(std::shared_ptr<const Terrain> terrain, void* owner);
  ~TerrainPatches();
  TerrainPatches(const TerrainPatches&) = delete;
  TerrainPatches& operator=(const TerrainPatches&) = delete;

  const Terrain& terrain() const { return *terrain_; }
  /// Whether a sphere may touch the terrain. Cheap.
  bool within(const Eigen::Vector3d& p_W, double radius) const;
  /// Puts the patches that a sphere reaches into space(). @return the anchor in W, origin of
  /// space()
  Eigen::Vector3d bring(const Eigen::Vector3d& p_W, double radius);
  dSpaceID space() const { return space_; }

 private:
  struct Patch {
    std::int64_t i = 0;
    std::int64_t j = 0;
    std::shared_ptr<const TriangleMesh> mesh;
    dTriMeshDataID data = nullptr;
    dGeomID geom = nullptr;
  };

  Patch& patch(std::int64_t i, std::int64_t j);
  static void destroy(const Patch& patch);

  std::shared_ptr<const Terrain> terrain_;
  void* owner_;
  dSpaceID space_;
  std::list<Patch> patches_;  // the newest first
  std::array<std::int64_t, 5> brought_{};
  Eigen::Vector3d anchor_W_ = Eigen::Vector3d::Zero();
};

}  // namespace cas::sim
