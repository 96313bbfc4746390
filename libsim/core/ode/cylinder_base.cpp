// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/cylinder_base.hpp"

#include <algorithm>
#include <cmath>

#include "libsim/core/ode/geometry.hpp"

namespace cas::sim {

namespace {

constexpr double kLevel = 1e-9;  // sine of the lean below which no point of a rim is the lowest

double depth_of(const HalfSpace& ground, const Eigen::Vector3d& p_W) {
  return ground.height_m - ground.n_W.dot(p_W);
}

PlacedCylinder cylinder_of(dGeomID geom) {
  PlacedCylinder out{.centre_W = from_ode(dGeomGetPosition(geom)),
                     .R_WC = rotation_of(geom),
                     .radius_m = 0,
                     .length_m = 0};
  dGeomCylinderGetParams(geom, &out.radius_m, &out.length_m);
  return out;
}

HalfSpace plane_of(dGeomID geom) {
  dVector4 p;
  dGeomPlaneGetParams(geom, p);
  return {.n_W = from_ode(p), .height_m = p[3]};
}

/// The face of a box that a point lies farthest beyond, and the half-space below it.
struct Face {
  HalfSpace ground;
  Eigen::Vector3d centre_W;
  Eigen::Matrix3d R_WB;
  Eigen::Vector3d half_m;
  Eigen::Index axis;

  Face(dGeomID box, const Eigen::Vector3d& p_W)
      : centre_W(from_ode(dGeomGetPosition(box))), R_WB(rotation_of(box)) {
    dVector3 size;
    dGeomBoxGetLengths(box, size);
    half_m = 0.5 * from_ode(size);
    const Eigen::Vector3d p_B = R_WB.transpose() * (p_W - centre_W);
    (p_B.cwiseAbs() - half_m).maxCoeff(&axis);
    const Eigen::Vector3d n_W = (p_B[axis] < 0 ? -1.0 : 1.0) * R_WB.col(axis);
    ground = {.n_W = n_W, .height_m = n_W.dot(centre_W) + half_m[axis]};
  }

  bool is_below(const Eigen::Vector3d& p_W) const {
    Eigen::Vector3d beyond = (R_WB.transpose() * (p_W - centre_W)).cwiseAbs() - half_m;
    beyond[axis] = 0;
    return beyond.maxCoeff() <= 0;
  }
};

}  // namespace

std::array<Eigen::Vector3d, 5> base_points(const PlacedCylinder& cylinder,
                                           const HalfSpace& ground) {
  const auto& [centre_W, R_WC, radius, length] = cylinder;
  const Eigen::Vector3d axis_W = R_WC.col(2);
  const double up = axis_W.dot(ground.n_W);
  const Eigen::Vector3d to_lower_W = (up < 0 ? 0.5 : -0.5) * length * axis_W;
  const Eigen::Vector3d lower_W = centre_W + to_lower_W;
  const Eigen::Vector3d down_W = up * axis_W - ground.n_W;  // in the base
  const double lean = down_W.norm();                        // sine of the angle to the ground
  const Eigen::Vector3d x_C = R_WC.col(0);
  const Eigen::Vector3d lowest_W = lean > kLevel ? Eigen::Vector3d(down_W / lean) : x_C;
  // Height of the highest of the four points above the middle of the base.
  const double rise =
      radius * std::max(std::abs(down_W.dot(x_C)), std::abs(down_W.dot(R_WC.col(1))));
  const bool is_in_all_around = depth_of(ground, lower_W) >= rise;
  const Eigen::Vector3d ahead_W = radius * (is_in_all_around ? x_C : lowest_W);
  const Eigen::Vector3d across_W = axis_W.cross(ahead_W);
  return {lower_W + ahead_W, lower_W + across_W, lower_W - across_W, lower_W - ahead_W,
          centre_W - to_lower_W + radius * lowest_W};
}

std::optional<std::size_t> collide_base(dGeomID a, dGeomID b, std::span<dContactGeom> out) {
  const bool is_turned = dGeomGetClass(a) != dCylinderClass;
  const dGeomID base = is_turned ? b : a;
  const dGeomID flat = is_turned ? a : b;
  const int kind = dGeomGetClass(flat);
  if (dGeomGetClass(base) != dCylinderClass || (kind != dPlaneClass && kind != dBoxClass)) {
    return std::nullopt;
  }
  const PlacedCylinder cylinder = cylinder_of(base);
  std::optional<Face> face;
  if (kind == dBoxClass) face.emplace(flat, cylinder.centre_W);
  const HalfSpace ground = face ? face->ground : plane_of(flat);
  const std::array<Eigen::Vector3d, 5> points = base_points(cylinder, ground);
  const auto is_over_face = [&](const Eigen::Vector3d& p_W) { return face->is_below(p_W); };
  if (face && !std::all_of(points.begin(), points.end(), is_over_face)) return std::nullopt;
  std::size_t count = 0;
  for (const Eigen::Vector3d& p_W : points) {
    const double depth = depth_of(ground, p_W);
    if (depth < 0) continue;
    dContactGeom& contact = out[count++];
    contact = {};
    std::copy_n(p_W.data(), 3, contact.pos);
    std::copy_n(ground.n_W.data(), 3, contact.normal);  // into g1, the cylinder
    contact.depth = depth;
    contact.g1 = base;
    contact.g2 = flat;
    contact.side1 = contact.side2 = -1;
  }
  return count;
}

}  // namespace cas::sim
