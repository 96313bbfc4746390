// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "libsim/core/export.hpp"
#include "libsim/core/ode/geometry.hpp"

namespace cas::sim {

/// The point of a triangle nearest to `p`, both in W, m. Source: [Ericson] 5.1.5.
CAS_SIM_EXPORT Eigen::Vector3d nearest_point(const Triangle& triangle, const Eigen::Vector3d& p);

/// A contact of a ball with a triangle.
struct BallContact {
  int triangle;          ///< number of the triangle in the mesh
  Eigen::Vector3d p_W;   ///< point of the triangle nearest to the ball's centre, m
  Eigen::Vector3d n_W;   ///< unit, from p_W to the centre
  double depth_m;        ///< of p_W in the ball
  bool is_face = false;  ///< p_W lies inside the triangle, not on a side or corner
};

/// Removes contacts with sides and corners that lie in the plane of another contact's face, within
/// the depth of that contact. Where triangles continue a surface, a ball that sinks into one also
/// overlaps the sides around it, and these contacts would push the ball sideways.
CAS_SIM_EXPORT void drop_sides_of_faces(std::vector<BallContact>& contacts);

/// Contacts of balls with triangles, one for each triangle. ODE makes one contact of all triangles,
/// whose mean normal leans towards the smaller ones: a ball would roll by itself on flat ground.
class BallOnMesh {
 public:
  BallOnMesh();
  ~BallOnMesh();
  BallOnMesh(const BallOnMesh&) = delete;
  BallOnMesh& operator=(const BallOnMesh&) = delete;

  /// Writes the contacts of a ball and a mesh to `out`, those with faces first.
  /// @return their number; nullopt for other pairs of shapes
  std::optional<std::size_t> collide(dGeomID a, dGeomID b, std::span<dContactGeom> out);

 private:
  static void on_triangles(dGeomID mesh, dGeomID probe, const int* indices, int count);

  dGeomID probe_;
  std::vector<BallContact> contacts_;  // of one pair
};

}  // namespace cas::sim
