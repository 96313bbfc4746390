// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <vector>

#include "libsim/core/body/shape.hpp"
#include "libsim/core/export.hpp"

namespace cas::sim {

/// The lowest surface of a world: a body below it falls for ever.
class CAS_SIM_EXPORT Floor {
 public:
  static constexpr double kMargin_m = 1.0;

  Floor() = default;
  /// @param statics  in W
  explicit Floor(std::span<const Shape> statics);

  /// Whether a sphere is below every plane that faces up and every other shape, by a metre. Never
  /// in a world without shapes, or with planes alone that face sideways or down: nothing was to
  /// hold it there.
  bool is_above(const Eigen::Vector3d& p_W, double radius) const;

 private:
  struct Ground {
    Eigen::Vector3d n;  // unit, up
    double d;
  };
  std::vector<Ground> planes_;
  double lowest_ = std::numeric_limits<double>::infinity();  // z of the other shapes
};

}  // namespace cas::sim
