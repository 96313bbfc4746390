// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/ball_on_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cas::sim {

namespace {

constexpr double kAcrossFace = 1 - 1e-9;     // cosine of 0.003 degree, between contact and face
constexpr double kNoDistance = 1e-12;        // m: below, the centre lies in the triangle
constexpr std::size_t kUsualContacts = 256;  // room for the contacts of one pair

}  // namespace

Eigen::Vector3d nearest_point(const Triangle& triangle, const Eigen::Vector3d& p) {
  const auto& [a, b, c] = triangle;
  const Eigen::Vector3d ab = b - a;
  const Eigen::Vector3d ac = c - a;
  const double d1 = ab.dot(p - a);
  const double d2 = ac.dot(p - a);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = ab.dot(p - b);
  const double d4 = ac.dot(p - b);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(p - c);
  const double d6 = ac.dot(p - c);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  }
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

void drop_sides_of_faces(std::vector<BallContact>& contacts) {
  const auto sides = std::stable_partition(contacts.begin(), contacts.end(),
                                           [](const BallContact& c) { return c.is_face; });
  const std::span<const BallContact> faces(contacts.begin(), sides);
  const auto lies_in_a_face = [faces](const BallContact& side) {
    return std::any_of(faces.begin(), faces.end(), [&](const BallContact& face) {
      return std::abs(face.n_W.dot(side.p_W - face.p_W)) <= face.depth_m;
    });
  };
  contacts.erase(std::remove_if(sides, contacts.end(), lies_in_a_face), contacts.end());
}

BallOnMesh::BallOnMesh() : probe_(dCreateSphere(nullptr, 1.0)) {
  dGeomSetData(probe_, this);
  contacts_.reserve(kUsualContacts);
}

BallOnMesh::~BallOnMesh() { dGeomDestroy(probe_); }

std::optional<std::size_t> BallOnMesh::collide(dGeomID a, dGeomID b, std::span<dContactGeom> out) {
  const bool is_turned = dGeomGetClass(a) != dSphereClass;
  const dGeomID ball = is_turned ? b : a;
  const dGeomID mesh = is_turned ? a : b;
  if (dGeomGetClass(ball) != dSphereClass || dGeomGetClass(mesh) != dTriMeshClass) {
    return std::nullopt;
  }
  contacts_.clear();
  const dReal* p = dGeomGetPosition(ball);
  dGeomSphereSetRadius(probe_, dGeomSphereGetRadius(ball));
  dGeomSetPosition(probe_, p[0], p[1], p[2]);
  dContactGeom hit;
  dGeomTriMeshSetArrayCallback(mesh, &on_triangles);
  dCollide(probe_, mesh, 1, &hit, sizeof(hit));
  dGeomTriMeshSetArrayCallback(mesh, nullptr);
  drop_sides_of_faces(contacts_);
  const std::size_t count = std::min(contacts_.size(), out.size());
  for (std::size_t i = 0; i < count; ++i) {
    const BallContact& found = contacts_[i];
    dContactGeom& contact = out[i];
    contact = {};
    std::copy_n(found.p_W.data(), 3, contact.pos);
    std::copy_n(found.n_W.data(), 3, contact.normal);  // into g1, the ball
    contact.depth = found.depth_m;
    contact.g1 = ball;
    contact.g2 = mesh;
    contact.side1 = -1;
    contact.side2 = found.triangle;
  }
  return count;
}

void BallOnMesh::on_triangles(dGeomID mesh, dGeomID probe, const int* indices, int count) {
  auto& self = *static_cast<BallOnMesh*>(dGeomGetData(probe));
  const Eigen::Vector3d centre_W = from_ode(dGeomGetPosition(probe));
  const double radius = dGeomSphereGetRadius(probe);
  for (const int index : std::span(indices, static_cast<std::size_t>(count))) {
    const Triangle triangle = triangle_of(mesh, index);
    const Eigen::Vector3d p_W = nearest_point(triangle, centre_W);
    const double distance = (centre_W - p_W).norm();
    if (distance >= radius || distance < kNoDistance) continue;
    const Eigen::Vector3d n_W = (centre_W - p_W) / distance;
    self.contacts_.push_back({.triangle = index,
                              .p_W = p_W,
                              .n_W = n_W,
                              .depth_m = radius - distance,
                              .is_face = std::abs(n_W.dot(normal_of(triangle))) > kAcrossFace});
  }
}

}  // namespace cas::sim
