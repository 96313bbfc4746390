// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/flat_ground.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace cas::sim {

namespace {

constexpr double kFlat = 1e-6;  // m: rounding of files in single precision

constexpr std::size_t kUsual = 1024;  // triangles in one question

double distance(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double along = std::clamp(ab.dot(p - a) / ab.squaredNorm(), 0.0, 1.0);
  return (a + along * ab - p).norm();
}

/// The side from corner `i` on.
TriangleSide side_of(const Triangle& triangle, std::size_t i, const Eigen::Vector3d& n_W) {
  Eigen::Vector3d a = triangle[i];
  Eigen::Vector3d b = triangle[(i + 1) % 3];
  const Eigen::Vector3d& third = triangle[(i + 2) % 3];
  if (std::lexicographical_compare(b.data(), b.data() + 3, a.data(), a.data() + 3)) std::swap(a, b);
  return {.corners = {a.x(), a.y(), a.z(), b.x(), b.y(), b.z()},
          .left = n_W.dot((b - a).cross(third - a)) > 0};
}

}  // namespace

bool is_flat_within(std::span<const Triangle> triangles, const Eigen::Vector3d& n_W,
                    const Eigen::Vector3d& centre_W, double radius_m,
                    std::vector<TriangleSide>& sides) {
  sides.clear();
  if (triangles.empty()) return false;
  const double height = n_W.dot(triangles.front().front());
  for (const Triangle& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (std::abs(n_W.dot(triangle[i]) - height) > kFlat) return false;
      if (distance(centre_W, triangle[i], triangle[(i + 1) % 3]) > radius_m) continue;
      sides.push_back(side_of(triangle, i, n_W));
    }
  }
  // Sides of two triangles stand side by side now; each needs one on its left and one on its right.
  std::sort(sides.begin(), sides.end(), [](const TriangleSide& a, const TriangleSide& b) {
    return a.corners != b.corners ? a.corners < b.corners : a.left < b.left;
  });
  for (auto first = sides.begin(); first != sides.end();) {
    const auto last = std::find_if(first, sides.end(), [&](const TriangleSide& side) {
      return side.corners != first->corners;
    });
    if (first->left == std::prev(last)->left) return false;
    first = last;
  }
  return true;
}

FlatGround::FlatGround() : probe_(dCreateSphere(nullptr, 1.0)) {
  dGeomSetData(probe_, this);
  triangles_.reserve(kUsual);
  sides_.reserve(3 * kUsual);
}

FlatGround::~FlatGround() { dGeomDestroy(probe_); }

std::optional<FlatSurface> FlatGround::around(dSpaceID statics, const Eigen::Vector3d& centre_W,
                                              double radius_m) {
  triangles_.clear();
  mesh_ = nullptr;
  alone_ = true;
  dGeomSphereSetRadius(probe_, radius_m);
  dGeomSetPosition(probe_, centre_W.x(), centre_W.y(), centre_W.z());
  dSpaceCollide2(probe_, reinterpret_cast<dGeomID>(statics), this, &on_near);
  if (!alone_ || triangles_.empty()) return std::nullopt;
  Eigen::Vector3d n_W = normal_of(triangles_.front());
  const Eigen::Vector3d& corner_W = triangles_.front().front();
  if (n_W.dot(centre_W - corner_W) < 0) n_W = -n_W;
  if (!is_flat_within(triangles_, n_W, centre_W, radius_m, sides_)) return std::nullopt;
  return FlatSurface{.ground = {.n_W = n_W, .height_m = n_W.dot(corner_W)}, .mesh = mesh_};
}

void FlatGround::on_near(void* self, dGeomID a, dGeomID b) {
  auto& ground = *static_cast<FlatGround*>(self);
  if (!ground.alone_) return;
  const dGeomID other = a == ground.probe_ ? b : a;
  dContactGeom hit;
  if (dGeomGetClass(other) != dTriMeshClass) {
    ground.alone_ = ground.alone_ && dCollide(ground.probe_, other, 1, &hit, sizeof(hit)) == 0;
    return;
  }
  dGeomTriMeshSetArrayCallback(other, &on_triangles);
  dCollide(ground.probe_, other, 1, &hit, sizeof(hit));
  dGeomTriMeshSetArrayCallback(other, nullptr);
}

void FlatGround::on_triangles(dGeomID mesh, dGeomID probe, const int* indices, int count) {
  auto& ground = *static_cast<FlatGround*>(dGeomGetData(probe));
  ground.alone_ = ground.alone_ && ground.mesh_ == nullptr;
  ground.mesh_ = mesh;
  for (const int index : std::span(indices, static_cast<std::size_t>(count))) {
    ground.triangles_.push_back(triangle_of(mesh, index));
  }
}

}  // namespace cas::sim
