// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "libsim/core/export.hpp"
#include "libsim/core/ode/contact_patch.hpp"

namespace cas::sim {

/// How a body has moved between two searches for its contacts.
struct BodyMove {
  Eigen::Vector3d from_W;   ///< its centre of gravity then, m
  Eigen::Vector3d to_W;     ///< and now
  Eigen::Quaterniond turn;  ///< in W

  /// Moves a point of the body along; the depth changes by its way out of the touched shape.
  /// @return its way, m
  double carry(ContactPoint& point) const {
    const Eigen::Vector3d p_W = to_W + turn * (point.p_W - from_W);
    const Eigen::Vector3d way_W = p_W - point.p_W;
    point.depth_m -= point.n_W.dot(way_W);
    point.p_W = p_W;
    return way_W.norm();
  }
};

/// Points that earlier searches found of a body on uneven ground.
///
/// Of one overlap a collision finds now these corners, now those, and a body that stands on either
/// in turn never comes to rest. A point is remembered with the body until it has left the ground or
/// slid by 5 mm.
class CAS_SIM_EXPORT RememberedPoints {
 public:
  /// Most points of one body.
  static constexpr std::size_t kMost = 64;

  RememberedPoints() { found_.reserve(kMost); }

  /// Adds those that this search did not find to `points`, and remembers the others of `points`
  /// that are on triangles. `points` have the same `kind` in each search.
  void add_to(std::vector<ContactPoint>& points, const BodyMove& since_last);
  void forget() { found_.clear(); }
  std::size_t size() const { return found_.size(); }

 private:
  struct Found {
    ContactPoint point;
    double slid_m = 0;  // since it was found
  };
  std::vector<Found> found_;
};

}  // namespace cas::sim
