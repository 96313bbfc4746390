// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "fcu/flight/flight_mode.hpp"

namespace cas::fcu {

enum class LandedState : std::uint8_t { kOnGround, kTakingOff, kInAir, kLanding };

/// What the controller believes and wants at its last step.
struct FlightStatus {
  bool armed = false;
  bool estimator_ready = false;
  FlightMode mode = FlightMode::kHold;
  LandedState landed = LandedState::kOnGround;
  std::uint64_t sensor_time_usec = 0;                           ///< stamp of the newest HIL_SENSOR
  Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();     ///< estimated attitude
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();                ///< estimated position, m
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();                ///< estimated velocity, m/s
  Eigen::Vector3d w_D = Eigen::Vector3d::Zero();                ///< estimated body rates, rad/s
  Eigen::Vector3d position_stddev_m = Eigen::Vector3d::Zero();  ///< the estimator's own opinion
  Eigen::Vector3d reference_N =
      Eigen::Vector3d::Zero();  ///< position reference, m (hold: NaN if none)
  double yaw_reference_rad = 0;
  Eigen::Vector4d u = Eigen::Vector4d::Zero();  ///< U1 (N), U2, U3, U4 (N m) as sent
};

}  // namespace cas::fcu
