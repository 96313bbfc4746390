// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/earth/frames.hpp"
#include "fcu/estimation/estimator.hpp"

namespace cas::fcu {

/// The place to return to.
struct Home {
  bool set = false;
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();  ///< m
  double yaw_rad = 0;                             ///< heading when home was set
  double ground_z = 0;  ///< z (down) of the ground at the take-off place, m

  /// Sets it to the present position.
  void set_here(const EstimatorState& state) {
    set = true;
    p_N = state.p_N;
    yaw_rad = base::euler_rpy(state.q_ND).z();
    ground_z = state.p_N.z();
  }
};

}  // namespace cas::fcu
