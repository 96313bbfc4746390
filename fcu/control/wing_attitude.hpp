// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "fcu/control/airspeed.hpp"
#include "fcu/control/pid.hpp"
#include "fcu/control/wing_params.hpp"

namespace cas::fcu {

/// Body rates of a level turn without sideslip: the heading turns by g tan(roll) / V about the
/// vertical, seen in the axes of D.
/// @param airspeed_m_s  true airspeed, above 0
/// @return rad/s
Eigen::Vector3d turn_rates_rad_s(double roll_rad, double pitch_rad, double airspeed_m_s);

/// Attitude and rate loops of a wing: roll and pitch by time constants, rates of the coordinated
/// turn added, then PI with feed-forward for each axis. Surfaces act by the dynamic pressure: gains
/// go with its inverse, feed-forward with that of the airspeed.
class WingAttitude {
 public:
  struct Input {
    double roll_rad = 0;        ///< wanted
    double pitch_rad = 0;       ///< wanted
    double yaw_rate_rad_s = 0;  ///< beside that of the turn: a nose that is steered on the ground
    Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();
    Eigen::Vector3d w_D = Eigen::Vector3d::Zero();  ///< rad/s
    Airspeed airspeed;
    bool integrate = true;  ///< not on the ground
  };

  void set_params(const WingParams& params);
  void reset() {
    for (Pid& pid : rate_) pid.reset();
  }
  /// @param dt  s
  /// @return shares of full deflection about Dx, Dy, Dz, -1..1
  Eigen::Vector3d update(const Input& in, double dt);
  const Eigen::Vector3d& wanted_rates() const { return wanted_w_D_; }

 private:
  WingParams params_;
  Pid rate_[3];
  Eigen::Vector3d wanted_w_D_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();
};

}  // namespace cas::fcu
