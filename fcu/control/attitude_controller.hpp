// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "fcu/control/control_params.hpp"
#include "fcu/control/setpoint.hpp"

namespace cas::fcu {

/// Attitude loop of [HILS] Fig. 8: proportional on the quaternion error, tilt before heading.
///
/// The shortest way to the wanted direction of thrust is followed at full gain, the heading that is
/// then left at a lower one (D. Brescianini, M. Hehn, R. D'Andrea, "Nonlinear Quadrocopter Attitude
/// Control", ETH Zurich, 2013).
class AttitudeController {
 public:
  void set_params(const ControlParams& params);

  /// @param turn_limit_rad_s  of a turn to a heading; 0: any heading will do, but no turning
  /// @return wanted body rates, axes of D, rad/s
  Eigen::Vector3d update(const AttitudeSetpoint& setpoint, const Eigen::Quaterniond& q_ND,
                         double turn_limit_rad_s = INFINITY) const;

 private:
  Eigen::Vector3d gain_{6.5, 6.5, 2.8};
  Eigen::Vector3d rate_limit_{3.8, 3.8, 3.5};
  double yaw_weight_ = 0.4;
};

}  // namespace cas::fcu
