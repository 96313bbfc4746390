// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <optional>

#include "libsim/api/world.hpp"

namespace cas::sim {

/// The stretch of a ray o + t d inside a convex solid, cut out by one pair of surfaces after the
/// other. Normals point out of the solid.
class ConvexStretch {
 public:
  ConvexStretch(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)
      : o_(origin), d_(direction) {}

  /// Two planes across an axis of the frame, at +-half.
  void cut_by_slab(Eigen::Index axis, double half) {
    if (d_[axis] == 0) {
      if (std::abs(o_[axis]) > half) cut_all();
      return;
    }
    const double side = d_[axis] > 0 ? 1 : -1;
    const Eigen::Vector3d out = side * Eigen::Vector3d::Unit(axis);
    keep((-side * half - o_[axis]) / d_[axis], -out, (side * half - o_[axis]) / d_[axis], out);
  }

  /// A sphere about the origin, or with only x and y counted a cylinder about z.
  /// @param counted  1 for the axes that count, else 0
  void cut_by_round(const Eigen::Vector3d& counted, double radius) {
    const Eigen::Vector3d o = o_.cwiseProduct(counted);
    const Eigen::Vector3d d = d_.cwiseProduct(counted);
    const double a = d.squaredNorm();
    const double b = o.dot(d);
    const double c = o.squaredNorm() - radius * radius;
    if (a == 0) {
      if (c > 0) cut_all();
      return;
    }
    const double discriminant = b * b - a * c;
    if (discriminant < 0) return cut_all();
    const double root = std::sqrt(discriminant);
    const double from = (-b - root) / a;
    const double to = (-b + root) / a;
    keep(from, (o + from * d) / radius, to, (o + to * d) / radius);
  }

  /// Where the ray enters the solid, or leaves it if it begins inside.
  std::optional<RayHit> first() const {
    if (begin_ > end_ || end_ < 0) return std::nullopt;
    if (begin_ >= 0) return RayHit{.distance_m = begin_, .normal = n_begin_};
    return RayHit{.distance_m = end_, .normal = n_end_};
  }

 private:
  void keep(double from, const Eigen::Vector3d& n_from, double to, const Eigen::Vector3d& n_to) {
    if (from > begin_) {
      begin_ = from;
      n_begin_ = n_from;
    }
    if (to < end_) {
      end_ = to;
      n_end_ = n_to;
    }
  }
  void cut_all() { end_ = -std::numeric_limits<double>::infinity(); }

  Eigen::Vector3d o_;
  Eigen::Vector3d d_;
  double begin_ = -std::numeric_limits<double>::infinity();
  double end_ = std::numeric_limits<double>::infinity();
  Eigen::Vector3d n_begin_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_end_ = Eigen::Vector3d::Zero();
};

}  // namespace cas::sim
