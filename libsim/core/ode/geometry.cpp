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
    return dCreateTriMesh(space, meshes.add(*mesh.triangles), nullptr, nullptr, nullptr);
  }
};

}  // namespace

MeshStore::~MeshStore() {
  for (const auto& mesh : meshes_) dGeomTriMeshDataDestroy(mesh->data);
}

dTriMeshDataID MeshStore::add(const TriangleMesh& mesh) {
  auto arrays = std::make_unique<Arrays>();
  arrays->vertices.reserve(3 * mesh.vertices.size());
  for (const Eigen::Vector3d& v : mesh.vertices) {
    arrays->vertices.insert(arrays->vertices.end(), {v.x(), v.y(), v.z()});
  }
  arrays->indices.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    arrays->indices.insert(arrays->indices.end(), t.begin(), t.end());
  }
  arrays->data = dGeomTriMeshDataCreate();
  dGeomTriMeshDataBuildDouble(arrays->data, arrays->vertices.data(), 3 * sizeof(double),
                              static_cast<int>(mesh.vertices.size()), arrays->indices.data(),
                              static_cast<int>(arrays->indices.size()), 3 * sizeof(dTriIndex));
  meshes_.push_back(std::move(arrays));
  return meshes_.back()->data;
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
