// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fcu/control/wing_params.hpp"

namespace cas::fcu {

/// Height and airspeed by throttle and pitch together: the throttle makes the energy of both, the
/// pitch shares it out (A. A. Lambregts, "Vertical Flight Path and Speed Control Autopilot Design
/// Using Total Energy Principles", AIAA 83-2239). Rates of energy are divided by m g V: a climb
/// angle, or an acceleration over gravity.
class TotalEnergy {
 public:
  struct Input {
    double height_error_m = 0;    ///< wanted minus measured
    double climb_wanted_m_s = 0;  ///< of the wanted height
    double climb_m_s = 0;         ///< measured
    double airspeed_wanted_m_s = 0;
    double airspeed_m_s = 0;
    double acceleration_m_s2 = 0;  ///< along the flight path
    bool by_climb_alone = false;   ///< flare: the height error and the speed do not count
  };
  struct Output {
    double throttle = 0;
    double path_angle_rad = 0;  ///< wanted angle of climb
  };

  void set_params(const WingParams& params) { params_ = params; }
  void reset() { throttle_integral_ = path_integral_ = 0; }
  /// @param dt  s
  Output update(const Input& in, double dt);

 private:
  double throttle_for(double rate, double error, double v, double dt);

  WingParams params_;
  double throttle_integral_ = 0;  // a share of the span
  double path_integral_ = 0;      // rad
};

}  // namespace cas::fcu
