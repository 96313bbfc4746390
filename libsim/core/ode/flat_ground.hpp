// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "libsim/core/export.hpp"
#include "libsim/core/ode/geometry.hpp"

namespace cas::sim {

/// A side of a triangle, its corners in one order whatever triangle it is of.
struct TriangleSide {
  std::array<double, 6> corners{};
  bool left = false;  ///< the triangle lies to the left of it
};

/// Whether triangles are one flat surface wherever a sphere reaches: all of them lie in one plane
/// across n_W, and no side of one passes through the sphere without another triangle beyond it. A
/// hole, an edge of the ground and a step are not flat; where sides do not end in the same corners
/// the answer is no, too.
/// @param sides  room to work in, so that nothing is taken from the heap in a step
CAS_SIM_EXPORT bool is_flat_within(std::span<const Triangle> triangles, const Eigen::Vector3d& n_W,
                                   const Eigen::Vector3d& centre_W, double radius_m,
                                   std::vector<TriangleSide>& sides);

/// A flat surface of a mesh.
struct FlatSurface {
  HalfSpace ground;  ///< its normal points to the side of the sphere's centre
  dGeomID mesh;
};

/// Finds surfaces of triangles that are flat as far as a body reaches.
class FlatGround {
 public:
  FlatGround();
  ~FlatGround();
  FlatGround(const FlatGround&) = delete;
  FlatGround& operator=(const FlatGround&) = delete;

  /// The flat surface of one mesh, if nothing else reaches into a sphere: for a body that stays
  /// inside the sphere, a plane can replace the mesh. nullopt else, and for ground without
  /// triangles.
  /// @param centre_W  centre of the sphere, m
  std::optional<FlatSurface> around(dSpaceID statics, const Eigen::Vector3d& centre_W,
                                    double radius_m);

 private:
  static void on_near(void* self, dGeomID a, dGeomID b);
  static void on_triangles(dGeomID mesh, dGeomID probe, const int* indices, int count);

  dGeomID probe_;
  std::vector<Triangle> triangles_;  // of one question
  std::vector<TriangleSide> sides_;  // the same
  dGeomID mesh_ = nullptr;           // whose they are
  bool alone_ = true;                // nothing else was met
};

}  // namespace cas::sim
