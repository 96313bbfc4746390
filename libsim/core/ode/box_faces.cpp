// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/box_faces.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "libsim/core/ode/geometry.hpp"

namespace cas::sim {

namespace {

constexpr double kFaceToFace = 0.995;  // cosine: faces that lie on each other, within 6 degrees

/// A box with the face whose outward normal is nearest to a direction.
struct BoxFace {
  Eigen::Vector3d centre_W;  // of the face
  Eigen::Matrix3d R_WB;
  Eigen::Vector3d half_m;
  Eigen::Index axis = 0;
  Eigen::Vector3d n_W;

  BoxFace(dGeomID box, const Eigen::Vector3d& direction_W) : R_WB(rotation_of(box)) {
    dVector3 size;
    dGeomBoxGetLengths(box, size);
    half_m = 0.5 * from_ode(size);
    const Eigen::Vector3d direction_B = R_WB.transpose() * direction_W;
    direction_B.cwiseAbs().maxCoeff(&axis);
    n_W = (direction_B[axis] < 0 ? -1.0 : 1.0) * R_WB.col(axis);
    centre_W = from_ode(dGeomGetPosition(box)) + half_m[axis] * n_W;
  }

  std::vector<Eigen::Vector3d> corners_W() const {
    const Eigen::Index u = (axis + 1) % 3;
    const Eigen::Index v = (axis + 2) % 3;
    const Eigen::Vector3d along_u = half_m[u] * R_WB.col(u);
    const Eigen::Vector3d along_v = half_m[v] * R_WB.col(v);
    return {centre_W + along_u + along_v, centre_W - along_u + along_v,
            centre_W - along_u - along_v, centre_W + along_u - along_v};
  }
};

/// The part of a polygon with n . p <= limit (Sutherland and Hodgman).
std::vector<Eigen::Vector3d> clipped(const std::vector<Eigen::Vector3d>& polygon,
                                     const Eigen::Vector3d& n, double limit) {
  std::vector<Eigen::Vector3d> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d& a = polygon[i];
    const Eigen::Vector3d& b = polygon[(i + 1) % polygon.size()];
    const double beyond_a = n.dot(a) - limit;
    const double beyond_b = n.dot(b) - limit;
    if (beyond_a <= 0) out.push_back(a);
    if ((beyond_a < 0) != (beyond_b < 0) && beyond_a != beyond_b) {
      out.push_back(a + beyond_a / (beyond_a - beyond_b) * (b - a));
    }
  }
  return out;
}

}  // namespace

std::optional<std::size_t> collide_faces(std::span<const dContactGeom> found,
                                         std::span<dContactGeom> out) {
  if (found.size() != 1) return std::nullopt;
  const dContactGeom edge = found.front();
  if (dGeomGetClass(edge.g1) != dBoxClass || dGeomGetClass(edge.g2) != dBoxClass) {
    return std::nullopt;
  }
  const Eigen::Vector3d n_W = from_ode(edge.normal);  // into the first box
  const BoxFace first(edge.g1, -n_W);
  const BoxFace second(edge.g2, n_W);
  const double first_fits = -first.n_W.dot(n_W);
  const double second_fits = second.n_W.dot(n_W);
  if (std::min(first_fits, second_fits) < kFaceToFace) return std::nullopt;

  const bool on_first = first_fits > second_fits;
  const BoxFace& ground = on_first ? first : second;
  std::vector<Eigen::Vector3d> overlap = (on_first ? second : first).corners_W();
  for (Eigen::Index side = 1; side < 3; ++side) {
    const Eigen::Index axis = (ground.axis + side) % 3;
    const Eigen::Vector3d side_W = ground.R_WB.col(axis);
    const double middle = side_W.dot(ground.centre_W);
    overlap = clipped(overlap, side_W, middle + ground.half_m[axis]);
    overlap = clipped(overlap, -side_W, ground.half_m[axis] - middle);
  }
  const Eigen::Vector3d normal_W = on_first ? Eigen::Vector3d(-ground.n_W) : ground.n_W;
  std::size_t count = 0;
  for (const Eigen::Vector3d& p_W : overlap) {
    const double depth_m = ground.n_W.dot(ground.centre_W - p_W);
    if (depth_m < 0 || count == out.size()) continue;
    dContactGeom& contact = out[count++] = edge;
    std::copy_n(p_W.data(), 3, contact.pos);
    std::copy_n(normal_W.data(), 3, contact.normal);
    contact.depth = depth_m;
  }
  if (count < 2) return std::nullopt;
  return count;
}

}  // namespace cas::sim
