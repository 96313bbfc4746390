// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace cas::fcu {

/// How rough the ride is, for VIBRATION: deviation of the specific force from its own mean.
struct VibrationMeter {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();    ///< specific force in D, m/s^2
  Eigen::Vector3d square = Eigen::Vector3d::Zero();  ///< of its deviation, m^2/s^4

  void update(const Eigen::Vector3d& accel_D) {
    constexpr double kShare = 0.002;
    const Eigen::Vector3d off = accel_D - mean;
    mean += kShare * off;
    square += kShare * (off.cwiseAbs2() - square);
  }
};

}  // namespace cas::fcu
