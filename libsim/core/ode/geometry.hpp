// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ode/ode.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
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
