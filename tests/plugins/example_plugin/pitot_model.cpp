// SPDX-License-Identifier: BSD-3-Clause
#include "pitot_model.hpp"

#include <algorithm>

namespace pitot {

AirspeedSample PitotModel::sample(cas::base::SimTime time, const Eigen::Quaterniond& q_WB,
                                  const Eigen::Vector3d& v_air_W, double density_kg_m3) {
  const Eigen::Vector3d v_air_B = q_WB.conjugate() * v_air_W;
  const double ahead = std::max(0.0, v_air_B.x());
  return {time, 0.5 * density_kg_m3 * ahead * ahead + stddev_pa_ * random_()};
}

}  // namespace pitot
