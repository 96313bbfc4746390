// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ode/ode.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <map>
#include <memory>

#include "libsim/core/body/shape.hpp"

namespace cas::sim {

inline Eigen::Vector3d from_ode(const dReal* v) { return {v[0], v[1], v[2]}; }
inline void to_ode(const Eigen::Quaterniond& q, dReal (&out)[4]) {
  out[0] = q.w();
  out[1] = q.x();
  out[2] = q.y();
  out[3] = q.z();
}

/// From the axes of a geom into W.
inline Eigen::Matrix3d rotation_of(dGeomID geom) {
  const dReal* r = dGeomGetRotation(geom);  // rows of four
  Eigen::Matrix3d R;
  R << r[0], r[1], r[2], r[4], r[5], r[6], r[8], r[9], r[10];
  return R;
}

/// A half-space: solid where n_W . p < height_m.
struct HalfSpace {
  Eigen::Vector3d n_W;  ///< unit, outwards
  double height_m;      ///< of the surface above the origin, along n_W
};

/// Corners of a triangle in W, m.
using Triangle = std::array<Eigen::Vector3d, 3>;

/// A triangle of a mesh, as the mesh stands in the world.
inline Triangle triangle_of(dGeomID mesh, int index) {
  std::array<dVector3, 3> corners;
  dGeomTriMeshGetTriangle(mesh, index, &corners[0], &corners[1], &corners[2]);
  return {from_ode(corners[0]), from_ode(corners[1]), from_ode(corners[2])};
}

/// Unit normal by the order of the corners; zero for a triangle without area.
inline Eigen::Vector3d normal_of(const Triangle& triangle) {
  const auto& [a, b, c] = triangle;
  const Eigen::Vector3d n = (b - a).cross(c - a);
  const double area = n.norm();
  return area > 0 ? Eigen::Vector3d(n / area) : Eigen::Vector3d::Zero();
}

/// Owns ODE's triangle meshes and their vertex data. Shapes of one mesh share it.
class MeshStore {
 public:
  ~MeshStore();
  dTriMeshDataID add(const std::shared_ptr<const TriangleMesh>& mesh);

 private:
  std::map<std::shared_ptr<const TriangleMesh>, dTriMeshDataID> meshes_;
};

/// Makes the geom of a shape at its pose in `space`. A plane becomes ODE's plane and must not be
/// attached to a body.
dGeomID make_geom(dSpaceID space, const Shape& shape, MeshStore& meshes);

}  // namespace cas::sim
