// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace cas::sim {

/// Share of the air that still follows the wing: 1 at small angles of attack, 1/2 at the stall, 0
/// far beyond, on both sides. It is 1 - sigma of [Beard] Eq. (4.10), written as a product of two
/// logistic functions, so that no exponential overflows.
///
/// @param angle_rad      of attack
/// @param sharpness      M, 1/rad
inline double attached_share(double angle_rad, double stall_rad, double sharpness) {
  return 1.0 / ((1.0 + std::exp(sharpness * (angle_rad - stall_rad))) *
                (1.0 + std::exp(-sharpness * (angle_rad + stall_rad))));
}

}  // namespace cas::sim
