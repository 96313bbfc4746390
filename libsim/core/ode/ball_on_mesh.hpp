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

/// The point of a triangle that is nearest to `p`, [Ericson] 5.1.5.
CAS_SIM_EXPORT Eigen::Vector3d nearest_point(const Triangle& triangle, const Eigen::Vector3d& p);

/// A triangle that reaches into a ball.
struct BallContact {
  int triangle;          ///< its number in the mesh
  Eigen::Vector3d p_W;   ///< its point nearest to the centre
  Eigen::Vector3d n_W;   ///< unit, from there to the centre
  double depth_m;        ///< of that point in the ball
  bool is_face = false;  ///< the point lies inside the triangle, not on a side or corner
};

/// Takes out contacts with sides and corners that lie in a face on which the ball has a contact
/// already, to within the depth of that: where triangles continue a surface, a ball that sinks
/// into it overlaps the sides around, and they would push it sideways.
CAS_SIM_EXPORT void drop_sides_of_faces(std::vector<BallContact>& contacts);

/// Contacts of balls with triangles. ODE makes one of all triangles, whose mean normal leans
/// towards the smaller ones: a ball would roll by itself on flat ground, and feet would shake.
class BallOnMesh {
 public:
  BallOnMesh();
  ~BallOnMesh();
  BallOnMesh(const BallOnMesh&) = delete;
  BallOnMesh& operator=(const BallOnMesh&) = delete;

  /// Contacts of a ball and a mesh, the faces' first; nullopt for other pairs.
  std::optional<std::size_t> collide(dGeomID a, dGeomID b, std::span<dContactGeom> out);

 private:
  static void on_triangles(dGeomID mesh, dGeomID probe, const int* indices, int count);

  dGeomID probe_;
  std::vector<BallContact> contacts_;  // of one pair
};

}  // namespace cas::sim
