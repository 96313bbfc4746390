// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>

#include "base/config/vehicle.hpp"
#include "fcu/control/saturation.hpp"

namespace cas::fcu {

/// The part of a demand that the rotors achieve.
struct MixerResult {
  Eigen::Vector4d u = Eigen::Vector4d::Zero();         ///< U1 (N), U2, U3, U4 (N m) achieved
  Eigen::Vector2d side_D_n = Eigen::Vector2d::Zero();  ///< force along Dx and Dy achieved, N
  base::RotorVector omega_sq;                          ///< of each rotor, rad^2/s^2; empty: all 0
  base::RotorVector tilt_rad;                          ///< of each rotor; empty: no servo
  Saturation thrust;                                   ///< up: no more U1, down: no less
  std::array<Saturation, 3> torque;                    ///< of U2, U3, U4
};

}  // namespace cas::fcu
