// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/geometry.hpp"

namespace cas::sim {

namespace {

struct Maker {
  dSpaceID space;
  const Eigen::Isometry3d& pose;
  MeshStore& meshes;

  dGeomID operator()(const Box& box) const {
    return dCreateBox(space, box.size_m.x(), box.size_m.y(), box.size_m.z());
  }
  dGeomID operator()(const Sphere& sphere) const { return dCreateSphere(space, sphere.radius_m); }
  dGeomID operator()(const Cylinder& c) const {
    return dCreateCylinder(space, c.radius_m, c.length_m);
  }
  dGeomID operator()(const Plane&) const {
    const Eigen::Vector3d n = pose.linear().col(2);
    return dCreatePlane(space, n.x(), n.y(), n.z(), n.dot(pose.translation()));
  }
  dGeomID operator()(const Mesh& mesh) const {
    return dCreateTriMesh(space, meshes.add(mesh.triangles), nullptr, nullptr, nullptr);
  }
};

}  // namespace

MeshStore::~MeshStore() {
  for (const auto& [mesh, data] : meshes_) dGeomTriMeshDataDestroy(data);
}

dTriMeshDataID MeshStore::add(const std::shared_ptr<const TriangleMesh>& mesh) {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double), "ODE reads the vertices in place");
  static_assert(sizeof(mesh->triangles[0]) == 3 * sizeof(dTriIndex), "and the indices");
  const auto [place, is_new] = meshes_.try_emplace(mesh, nullptr);
  if (!is_new) return place->second;
  place->second = dGeomTriMeshDataCreate();
  dGeomTriMeshDataBuildDouble(place->second, mesh->vertices.data(), 3 * sizeof(double),
                              static_cast<int>(mesh->vertices.size()), mesh->triangles.data(),
                              static_cast<int>(3 * mesh->triangles.size()), 3 * sizeof(dTriIndex));
  return place->second;
}

dGeomID make_geom(dSpaceID space, const Shape& shape, MeshStore& meshes) {
  const dGeomID geom = std::visit(Maker{space, shape.pose, meshes}, shape.geometry);
  if (!std::holds_alternative<Plane>(shape.geometry)) {
    dReal q[4];
    to_ode(Eigen::Quaterniond(shape.pose.linear()), q);
    const Eigen::Vector3d p = shape.pose.translation();
    dGeomSetPosition(geom, p.x(), p.y(), p.z());
    dGeomSetQuaternion(geom, q);
  }
  return geom;
}

}  // namespace cas::sim
