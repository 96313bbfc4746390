// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "libsim/core/export.hpp"
#include "libsim/core/ode/contact_patch.hpp"

namespace cas::sim {

/// Motion of a body between two searches for its contacts.
struct BodyMove {
  Eigen::Vector3d from_W;   ///< centre of gravity at the first search, m
  Eigen::Vector3d to_W;     ///< centre of gravity at the second, m
  Eigen::Quaterniond turn;  ///< rotation between them, in W

  /// Moves a contact point with the body, and changes its depth by its way along the normal.
  /// @return length of the way, m
  double carry(ContactPoint& point) const {
    const Eigen::Vector3d p_W = to_W + turn * (point.p_W - from_W);
    const Eigen::Vector3d way_W = p_W - point.p_W;
    point.depth_m -= point.n_W.dot(way_W);
    point.p_W = p_W;
    return way_W.norm();
  }
};

/// Contact points of a body on uneven ground that earlier searches found.
///
/// Each search finds other corners of the same overlap, and a body whose support changes with each
/// of them never comes to rest. So a point is remembered, and moves with the body, until it has
/// left the ground or slid by 5 mm.
class CAS_SIM_EXPORT RememberedPoints {
 public:
  /// Most points of one body.
  static constexpr std::size_t kMost = 64;

  RememberedPoints() { found_.reserve(kMost); }

  /// Adds to `points`, the result of this search, the remembered points that it lacks; remembers
  /// new points on triangles. ContactPoint::kind must mean the same in each search.
  void add_to(std::vector<ContactPoint>& points, const BodyMove& since_last);
  void forget() { found_.clear(); }
  std::size_t size() const { return found_.size(); }

 private:
  struct Found {
    ContactPoint point;
    double slid_m = 0;  // way since it was found
  };
  std::vector<Found> found_;
};

}  // namespace cas::sim
