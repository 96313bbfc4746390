// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string_view>

#include "base/time/clock.hpp"

namespace cas::sim {

/// Position, attitude, velocity and rates of a visual-inertial unit or of motion capture, in a
/// frame F of its own: x along its heading, y to the right of it, z down.
struct OdometrySample {
  static constexpr std::string_view kTypeName = "cas.OdometrySample";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;  ///< of measurement, before the delay
  Eigen::Vector3d position_F_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_FD = Eigen::Quaterniond::Identity();  ///< turns vectors from D into F
  Eigen::Vector3d velocity_D_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_D_rad_s = Eigen::Vector3d::Zero();
  std::uint8_t reset_counter = 0;  ///< one more with each jump that the sensor knows of
  std::int8_t quality = 0;         ///< %: -1 has failed, 0 is unknown, 100 is best
};

}  // namespace cas::sim
