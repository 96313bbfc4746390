// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/random.hpp"

namespace cas::sim {

/// Three independent normal deviates, drawn in the order x, y, z.
inline Eigen::Vector3d normal3(base::NormalRandom& random) {
  const double x = random();
  const double y = random();
  const double z = random();
  return {x, y, z};
}

}  // namespace cas::sim
