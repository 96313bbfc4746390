// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "base/time/clock.hpp"
#include "mavlink/common/obstacle_distance.hpp"

namespace cas::sim {

/// The nearest obstacle around a vehicle in 72 sectors of 5 degrees, for OBSTACLE_DISTANCE in the
/// frame MAV_FRAME_BODY_FRD. PX4 and ArduPilot keep to the level plane: sector i is about i * 5
/// degrees clockwise from the vehicle's heading, and distances are horizontal, from the sensor.
class ObstacleSectors {
 public:
  static constexpr std::size_t kSectors = 72;

  /// Number of the sector. @param azimuth_rad  clockwise from the heading
  static std::size_t sector_of(double azimuth_rad);

  /// A beam has looked there and found nothing, or nothing at the vehicle's height.
  void see_free(double azimuth_rad);
  /// A beam has found something. @param distance_m  horizontal
  void see_obstacle(double azimuth_rad, double distance_m);

  /// Sectors that no beam has looked into are unknown.
  /// @param min_m, max_m  range of the sensor
  mavlink::common::ObstacleDistance message(base::SimTime time, double min_m, double max_m) const;
  /// Back to all unknown.
  void clear() { *this = {}; }

 private:
  struct Sector {
    bool seen = false;
    bool hit = false;
    double distance_m = 0;
  };
  std::array<Sector, kSectors> sectors_{};
};

}  // namespace cas::sim
