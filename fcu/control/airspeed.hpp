// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cas::fcu {

/// Speed through the air.
struct Airspeed {
  double equivalent_m_s = 0;  ///< at which air of sea level's density has the same dynamic pressure
  double true_m_s = 0;
  bool measured = false;  ///< by a pitot tube; else the speed over ground stands in
};

}  // namespace cas::fcu
