// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/time/clock.hpp"

namespace cas::sim {

/// A return of one beam.
struct CloudPoint {
  Eigen::Vector3f p_S;  ///< m, in the axes S of the sensor (forward, left, up) when the beam fired
  Eigen::Vector3f p_W;  ///< m, the same place in the world
  float cosine = 0;     ///< of the angle of incidence
  float time_s = 0;     ///< since the scan began
  std::uint16_t ring = 0;
};

/// One scan of a lidar, published when it is whole. `points` are valid inside publish() only.
struct PointCloud {
  static constexpr std::string_view kTypeName = "cas.PointCloud";
  static constexpr unsigned kTypeVersion = 2;
  std::uint64_t number = 0;                                  ///< from 0
  base::SimTime begin;                                       ///< when its first beam fired
  Eigen::Vector3d p_WS = Eigen::Vector3d::Zero();            ///< the sensor's place then, m
  Eigen::Quaterniond q_WS = Eigen::Quaterniond::Identity();  ///< and attitude
  std::span<const CloudPoint> points;
};

/// Topic of a vehicle's lidars: "lidar", of the second one "lidar_2".
inline std::string lidar_topic(int number) {
  return number == 1 ? "lidar" : "lidar_" + std::to_string(number);
}

/// Places in W of at most `most` returns for a picture, spread evenly over the scan. Beams that
/// fire at once are a power of two: an odd stride has some of each ring.
inline std::vector<Eigen::Vector3f> drawn_points(const PointCloud& cloud, std::size_t most) {
  const std::size_t stride = (cloud.points.size() + most - 1) / most | 1U;
  std::vector<Eigen::Vector3f> drawn;
  for (std::size_t i = 0; i < cloud.points.size(); i += stride) {
    drawn.push_back(cloud.points[i].p_W);
  }
  return drawn;
}

}  // namespace cas::sim
