// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "base/earth/geodesy.hpp"

namespace cas::sim {

/// The attitude, place and velocity that the unit computes, in N and D.
struct UnitSolution {
  Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();
  base::Geodetic position;                               ///< altitude above mean sea level
  Eigen::Vector3d velocity_N = Eigen::Vector3d::Zero();  ///< m/s
  double attitude_sigma_deg = 0;
  double position_sigma_m = 0;
  double velocity_sigma_m_s = 0;
};

/// The receiver's newest fix.
struct UnitFix {
  std::uint8_t type = 0;  ///< by VectorNav: 0 none, 2 2D, 3 3D, 4 SBAS, 7 RTK float, 8 RTK fixed
  std::uint8_t satellites = 0;
  base::Geodetic position;                               ///< altitude above mean sea level
  Eigen::Vector3d velocity_N = Eigen::Vector3d::Zero();  ///< m/s
  double horizontal_sigma_m = 0;
  double vertical_sigma_m = 0;
  double velocity_sigma_m_s = 0;
};

/// What the unit knows when it builds a packet; forward-right-down, SI.
struct UnitReadings {
  std::uint64_t startup_ns = 0;                       ///< since the unit's start
  std::uint64_t gps_ns = 0;                           ///< since 6 January 1980, GPS time
  Eigen::Vector3d accel_D = Eigen::Vector3d::Zero();  ///< specific force, m/s^2
  Eigen::Vector3d gyro_D = Eigen::Vector3d::Zero();   ///< rad/s
  Eigen::Vector3d field_D = Eigen::Vector3d::Zero();  ///< gauss
  double temperature_degc = 0;
  double pressure_pa = 0;
  UnitSolution solution;
  UnitFix fix;
  bool has_second_receiver = false;  ///< VN-300
};

}  // namespace cas::sim
