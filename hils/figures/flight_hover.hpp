// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "hils/virtual/direct_flight.hpp"

namespace cas::hils {

inline constexpr double kHoverHeight_m = 2.5;
inline constexpr double kLightTurbulence_m_s = 15 * 0.514444;  // W20 of MIL-F-8785C, 15 knots
inline const Eigen::Vector3d kHoverPlace_N(0, 0, -kHoverHeight_m);

/// Takes off, goes to the place of the hover, nose to the north, and waits.
inline bool begin_hover(DirectFlight& flight, double settle_s) {
  if (!flight.take_off(kHoverHeight_m)) return false;
  flight.go_to(0, 0, kHoverHeight_m, 0);
  flight.run(settle_s);
  return true;
}

}  // namespace cas::hils
