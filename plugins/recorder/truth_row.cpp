// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/recorder/truth_row.hpp"

#include "base/earth/frames.hpp"

namespace cas::sim {

std::array<double, kTruthColumns> truth_row(base::SimTime time, const BodyState& state,
                                            const Eigen::Vector4d& omega) {
  const Eigen::Vector3d p_N = base::swap_WN(state.p_WB);
  const Eigen::Vector3d v_N = base::swap_WN(state.v_WB);
  const Eigen::Vector3d rpy = base::euler_rpy(base::q_ND_from_q_WB(state.q_WB));
  const Eigen::Vector3d w_D = base::swap_BD(state.w_WB_B);
  return {base::to_seconds(time),
          p_N.x(),
          p_N.y(),
          -p_N.z(),
          v_N.x(),
          v_N.y(),
          -v_N.z(),
          rpy.x(),
          rpy.y(),
          rpy.z(),
          w_D.x(),
          w_D.y(),
          w_D.z(),
          omega[0],
          omega[1],
          omega[2],
          omega[3]};
}

}  // namespace cas::sim
