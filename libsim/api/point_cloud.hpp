// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <string_view>

#include "base/time/clock.hpp"

namespace cas::sim {

/// A return of one beam, in the axes S of the sensor (forward, left, up) when the beam fired.
struct CloudPoint {
  Eigen::Vector3f p_S;  ///< m
  float cosine = 0;     ///< of the angle of incidence
  float time_s = 0;     ///< since the scan began
  std::uint16_t ring = 0;
};

/// One scan of a lidar, published when it is whole. `points` are valid inside publish() only.
struct PointCloud {
  static constexpr std::string_view kTypeName = "cas.PointCloud";
  static constexpr unsigned kTypeVersion = 1;
  std::uint64_t number = 0;                                  ///< from 0
  base::SimTime begin;                                       ///< when its first beam fired
  Eigen::Vector3d p_WS = Eigen::Vector3d::Zero();            ///< the sensor's place then, m
  Eigen::Quaterniond q_WS = Eigen::Quaterniond::Identity();  ///< and attitude
  std::span<const CloudPoint> points;
};

}  // namespace cas::sim
